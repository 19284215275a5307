// The method with which clients read the latest entries of the log. Independent of the transport. Event
// loop's thread only.
#pragma once

#include <cstddef>

#include "daemon/control/control_method.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class LogControl {
 public:
  // Maximum number of bytes of the messages in one reply.
  static constexpr std::size_t kMostBytes = 32'768;

  // The log must outlive the control.
  explicit LogControl(const Log& log) : log_(log) {}

  // Returns the method by its name. The control must outlive it.
  [[nodiscard]] ControlMethods methods();

 private:
  [[nodiscard]] ControlMethod::Json entries(std::size_t most) const;

  const Log& log_;
};

}  // namespace contourd
