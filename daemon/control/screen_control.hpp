// The method with which clients get the picture on the display. Independent of the transport. Event loop's
// thread only.
#pragma once

#include <cstddef>
#include <optional>

#include "daemon/control/control_method.hpp"
#include "daemon/control/screen_copy.hpp"
#include "daemon/jobs/current_job.hpp"
#include "daemon/print/manual_process.hpp"

namespace contourd {

class ScreenControl {
 public:
  using Json = ControlMethod::Json;

  // All arguments must outlive the control.
  ScreenControl(EventLoop& loop, Worker& worker, const CurrentJob& job, const ManualProcess& manual);

  // Returns the method by its name. The control must outlive it.
  [[nodiscard]] ControlMethods methods();

 private:
  // The mask or picture that is or was shown last.
  struct Subject {
    ShownMask shown;
    bool on_screen = false;
  };

  void mask(const Json& given, ControlMethod::Later later);
  [[nodiscard]] Subject subject() const;
  [[nodiscard]] Json reply(const ScreenCopy::Picture& picture, std::size_t from) const;

  const CurrentJob& job_;
  const ManualProcess& manual_;
  ScreenCopy copy_;
};

}  // namespace contourd
