#pragma once

#define PLUGINLIB_EXPORT_CLASS(type, base) \
  base &controller_interface::loaded() {   \
    static type controller;                \
    return controller;                     \
  }
