// A 1 kHz loop round the calibrated model of an arm, as a controller has one.
//
//   mukca export calibrated/calibration.json --to c --out arm.c
//   cc -std=c99 -O2 -c arm.c
//   c++ -std=c++11 -O2 loop.cpp arm.o -o loop
//   ./loop
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "arm.h"

int main(int count, char **words) {
  using clock = std::chrono::steady_clock;
  const int cycles = count > 1 ? std::atoi(words[1]) : 1000;
  double worst = 0, target[ARM_JOINTS], command[ARM_JOINTS], ball[3], J[6 * ARM_JOINTS];
  clock::time_point next = clock::now();
  for (int cycle = 0; cycle < cycles; ++cycle) {
    // Where the arm is to stand; a real loop takes this from its planner.
    for (int i = 0; i < ARM_JOINTS; ++i) {
      const double middle = (std::max(arm_lower[i], -3.0) + std::min(arm_upper[i], 3.0)) / 2;
      target[i] = middle + 0.5 * std::sin(1e-3 * cycle + i);
    }
    const clock::time_point begin = clock::now();
    if (arm_command(target, command) != 0) return 1;  // what to send
    arm_ball(command, ball);                          // where the ball will be
    arm_jacobian(command, J);                         // for speeds in the base frame
    const std::chrono::duration<double, std::micro> took = clock::now() - begin;
    worst = std::max(worst, took.count());
    next += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(next);
  }
  std::printf("ball at %.4f %.4f %.4f m; ", ball[0], ball[1], ball[2]);
  std::printf("the slowest of %d cycles computed for %.1f us\n", cycles, worst);
  return 0;
}
