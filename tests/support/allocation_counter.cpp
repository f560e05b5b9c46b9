#include "tests/support/allocation_counter.h"

#include <atomic>
#include <cstdlib>
#include <new>

// What replaces operator new must itself use malloc.
// NOLINTBEGIN(cppcoreguidelines-no-malloc)

namespace {

std::atomic<std::size_t> allocations{0};

void* Allocate(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

// The array and sized forms call these two by default; over-aligned types are not counted.
void* operator new(std::size_t size) { return Allocate(size); }
void* operator new[](std::size_t size) { return Allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

// NOLINTEND(cppcoreguidelines-no-malloc)

namespace uiclink {

std::size_t CountAllocations() { return allocations.load(std::memory_order_relaxed); }

}  // namespace uiclink
