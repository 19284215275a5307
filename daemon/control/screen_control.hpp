// The method by which an owner's programs see what the display shows. It knows no transport. Event loop's
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
  // Of a picture's file in one reply.
  static constexpr std::size_t kPieceBytes = 49'152;

  // All must outlive the control.
  ScreenControl(EventLoop& loop, Worker& worker, const CurrentJob& job, const ManualProcess& manual);

  // By name. The control must outlive it.
  [[nodiscard]] ControlMethods methods();

 private:
  // What a picture is of, for as long as that is known.
  struct Subject {
    ShownMask shown;
    bool on_screen = false;
  };

  std::optional<Json> mask(const Json& given, ControlMethod::Later later);
  [[nodiscard]] Subject subject() const;
  [[nodiscard]] Json reply(const ScreenCopy::Picture& picture, std::size_t from) const;

  const CurrentJob& job_;
  const ManualProcess& manual_;
  ScreenCopy copy_;
};

}  // namespace contourd
