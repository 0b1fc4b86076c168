// Reads references, a row a line; prints what was commanded, then the states that are exported.
#include <cstdio>
#include <iostream>

#include "controller_interface/chainable_controller_interface.hpp"

static void print(const std::vector<double> &row) {
  for (double value : row) std::printf("%.17g ", value);
  std::printf("\n");
}

int main() {
  controller_interface::Manager manager(controller_interface::loaded());
  for (const auto &reference : manager.references) std::printf("%s ", reference.full_name.c_str());
  std::printf("\n");
  manager.update();
  for (double command : manager.hardware)
    if (command != 0) return 1;  // nobody has given a reference yet
  std::vector<double> row(manager.references.size());
  while (std::cin >> row[0]) {
    for (std::size_t i = 1; i < row.size(); ++i) std::cin >> row[i];
    for (std::size_t i = 0; i < row.size(); ++i) (void)manager.references[i].set_value(row[i]);
    manager.update();
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = manager.states[i].get_value();
    print(manager.hardware);
    print(row);
  }
  return 0;
}
