# What every target of ours has, in one place.

# A sum of products is rounded twice, never fused. GCC fuses by default wherever the processor can; the x86-64 baseline
# cannot, so there this changes nothing, but on other machines fits, tests and the rig's records would differ in the
# last digits. For the same reason no preset says -march=native. (The C library's sin and exp remain its own affair.)
add_compile_options(-ffp-contract=off)

# Clang 14 and GCC disagree on the mangled name of fmt 9's vformat_to(), so clang cannot link Debian's libfmt.
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
  add_compile_definitions(FMT_HEADER_ONLY=1)
endif()

# Warnings for our own code only: never installed, never seen by third-party code.
add_library(uiclink_warnings INTERFACE)
target_compile_options(uiclink_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # GCC 12 warns falsely on std::string + (GCC bug 105651)
  $<$<BOOL:${UICLINK_WERROR}>:-Werror>)

# uiclink_add_library(name SOURCES ... [HEADERS ...] [PUBLIC libs...] [PRIVATE libs...])
# HEADERS are what the installed package offers; they keep their folder: <uiclink/vehicle/contact/profile.h> is
# vehicle/contact/profile.h, though its library is called contact.
function(uiclink_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;HEADERS;PUBLIC;PRIVATE" ${ARGN})
  set(target uiclink_${name})
  add_library(${target} ${ARG_SOURCES})
  add_library(uiclink::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>           # <uiclink/model/arc.h>, what a user writes
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/uiclink>)  # "model/arc.h", what our headers write
  target_link_libraries(${target}
    PUBLIC ${ARG_PUBLIC}
    PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:uiclink_warnings>)
  install(TARGETS ${target} EXPORT uiclinkTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE room)
  foreach(header IN LISTS ARG_HEADERS)
    cmake_path(GET header PARENT_PATH folder)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/uiclink/${room}/${folder})
  endforeach()
endfunction()

# uiclink_add_program(target NAME program SOURCES ... LIBRARIES ...)
function(uiclink_add_program target)
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${target} ${ARG_SOURCES})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${ARG_NAME})
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE ${ARG_LIBRARIES} uiclink_warnings)
endfunction()

# uiclink_add_test(name [LABELS unit] [LIBRARIES ...] [TIMEOUT s] SOURCES ...): one GoogleTest program, one CTest entry per test case.
# LABELS defaults to the name of the folder.
function(uiclink_add_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LIBRARIES;LABELS" ${ARGN})
  if(NOT ARG_LABELS)
    cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME ARG_LABELS)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${name} PRIVATE UICLINK_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} GTest::gtest_main GTest::gmock uiclink_warnings)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests/bin)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT})
endfunction()
