// The parts of ros2_control's interface that the example uses, with the same names and types.
#pragma once
#include <memory>
#include <string>
#include <vector>

namespace rclcpp {
struct Time {};
struct Duration {};
}  // namespace rclcpp

namespace rclcpp_lifecycle {
struct State {};
}  // namespace rclcpp_lifecycle

namespace hardware_interface {
struct Handle {
  Handle(const std::string &prefix, const std::string &name, double *place)
      : full_name(prefix + "/" + name), place(place) {}
  std::string full_name;
  double *place;
  double get_value() const { return *place; }
  [[nodiscard]] bool set_value(double value) {
    *place = value;
    return true;
  }
};
using CommandInterface = Handle;
using StateInterface = Handle;
}  // namespace hardware_interface

namespace controller_interface {
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };

struct InterfaceConfiguration {
  interface_configuration_type type;
  std::vector<std::string> names;
};

struct Node {
  const char *get_name() const { return "table"; }
};

class ChainableControllerInterface {
 public:
  virtual ~ChainableControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) = 0;
  std::shared_ptr<Node> get_node() const { return std::make_shared<Node>(); }

 protected:
  virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() = 0;
  virtual std::vector<hardware_interface::StateInterface> on_export_state_interfaces() = 0;
  virtual return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  virtual return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &) = 0;

  std::vector<double> reference_interfaces_, state_interfaces_values_;
  std::vector<hardware_interface::CommandInterface> command_interfaces_;
  std::vector<hardware_interface::StateInterface> state_interfaces_;

  friend class Manager;
};

// A controller manager with hardware that goes where it is sent at once.
class Manager {
 public:
  explicit Manager(ChainableControllerInterface &controller) : controller(controller) {
    const InterfaceConfiguration commands = controller.command_interface_configuration();
    hardware.assign(commands.names.size(), 0.0);
    for (std::size_t i = 0; i < hardware.size(); ++i) {
      controller.command_interfaces_.emplace_back("", commands.names[i], &hardware[i]);
      controller.state_interfaces_.emplace_back("", commands.names[i], &hardware[i]);
    }
    controller.on_init();
    references = controller.on_export_reference_interfaces();
    states = controller.on_export_state_interfaces();
    controller.on_activate({});
  }

  // Twice: states are read before commands are written.
  void update() {
    for (int cycle = 0; cycle < 2; ++cycle) {
      controller.update_reference_from_subscribers({}, {});
      controller.update_and_write_commands({}, {});
    }
  }

  ChainableControllerInterface &controller;
  std::vector<double> hardware;
  std::vector<hardware_interface::Handle> references, states;
};

ChainableControllerInterface &loaded();
}  // namespace controller_interface
