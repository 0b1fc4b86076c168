#include <cstdio>
#include <cstring>
#include <research_interface/robot/rbk_types.h>

int main() {
  research_interface::robot::RobotState state;
  for (int number = 1; number <= 10000; number++) {
    std::memset(static_cast<void*>(&state), 0, sizeof state);
    state.message_id = number;
    for (int joint = 0; joint < 7; joint++) {
      state.q[joint] = (number % 613 - 306) / 64.0 / (joint + 1);
      state.tau_J[joint] = number % 997 / 16.0 - joint;
      state.theta[joint] = 9.0;
    }
    state.errors[number % 37] = true;
    state.robot_mode = static_cast<decltype(state.robot_mode)>(number % 7);
    state.control_command_success_rate = 0.5;
    std::fwrite(&state, sizeof state, 1, stdout);
  }
}
