// A ros2_control controller (Jazzy) between a trajectory controller and the hardware: it adds the
// offsets of a joint table to commanded positions, and takes them off the measured ones.
//
//   mukca export calibrated/calibration.json --to joint-table --out arm.csv
//
// The header arm.h, which that writes, goes beside this file.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "arm.h"
#include "controller_interface/chainable_controller_interface.hpp"
#include "pluginlib/class_list_macros.hpp"

namespace joint_table {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::return_type;

class JointTableController : public controller_interface::ChainableControllerInterface {
 public:
  CallbackReturn on_init() override { return CallbackReturn::SUCCESS; }

  InterfaceConfiguration command_interface_configuration() const override { return positions(); }

  InterfaceConfiguration state_interface_configuration() const override { return positions(); }

  // Nothing is commanded before a controller above this one has said where the joints shall stand.
  CallbackReturn on_activate(const rclcpp_lifecycle::State &) override {
    reference_interfaces_.assign(ARM_JOINTS, std::numeric_limits<double>::quiet_NaN());
    read_states();
    return CallbackReturn::SUCCESS;
  }

 protected:
  std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() override {
    reference_interfaces_.assign(ARM_JOINTS, std::numeric_limits<double>::quiet_NaN());
    std::vector<hardware_interface::CommandInterface> exported;
    for (int i = 0; i < ARM_JOINTS; ++i)
      exported.emplace_back(name_of(i), "position", &reference_interfaces_[i]);
    return exported;
  }

  std::vector<hardware_interface::StateInterface> on_export_state_interfaces() override {
    state_interfaces_values_.assign(ARM_JOINTS, std::numeric_limits<double>::quiet_NaN());
    std::vector<hardware_interface::StateInterface> exported;
    for (int i = 0; i < ARM_JOINTS; ++i)
      exported.emplace_back(name_of(i), "position", &state_interfaces_values_[i]);
    return exported;
  }

  // Only controllers above this one give references.
  return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) override {
    return return_type::OK;
  }

  return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &) override {
    read_states();
    for (int i = 0; i < ARM_JOINTS; ++i)
      if (std::isfinite(reference_interfaces_[i]))
        (void)command_interfaces_[i].set_value(arm_command(i, reference_interfaces_[i]));
    return return_type::OK;
  }

 private:
  std::string name_of(int joint) const {
    return std::string(get_node()->get_name()) + "/" + arm_joint_names[joint];
  }

  // In the order of the table, which is that of command_interfaces_ and state_interfaces_.
  InterfaceConfiguration positions() const {
    InterfaceConfiguration wanted{controller_interface::interface_configuration_type::INDIVIDUAL, {}};
    for (const char *joint : arm_joint_names) wanted.names.push_back(std::string(joint) + "/position");
    return wanted;
  }

  void read_states() {
    for (int i = 0; i < ARM_JOINTS; ++i)
      state_interfaces_values_[i] = arm_state(i, state_interfaces_[i].get_value());
  }
};

}  // namespace joint_table

PLUGINLIB_EXPORT_CLASS(joint_table::JointTableController, controller_interface::ChainableControllerInterface)
