// What a program outside of this project writes to use the library.
#include <iostream>

#include <uiclink/model/parameter_set.h>

int main() {
  const char* separator = "";
  for (const std::string& symbol : uiclink::ParameterSymbols(1)) {
    std::cout << separator << symbol;
    separator = " ";
  }
  std::cout << '\n';
}
