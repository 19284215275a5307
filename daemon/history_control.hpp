// The methods by which an owner's programs ask what became of their jobs. They know no transport. Event
// loop's thread only.
#pragma once

#include "daemon/control_method.hpp"
#include "daemon/job_history.hpp"
#include "daemon/kept_history.hpp"

namespace contourd {

class HistoryControl {
 public:
  using Json = ControlMethod::Json;
  // A reply's jobs.
  static constexpr std::size_t kLongestPage = 100;

  // Both must outlive the control. `recent` is asked where the kept one cannot be.
  HistoryControl(KeptHistory& kept, const JobHistory& recent) : kept_(kept), recent_(recent) {}

  // All of them, by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();
  // What it asked is not answered any more.
  void disconnected(std::uint64_t connection) { kept_.disconnected(connection); }

 private:
  std::optional<Json> history(const Json& given, const ControlCaller& caller, ControlMethod::Later later);
  std::optional<Json> usage(const ControlCaller& caller, ControlMethod::Later later);

  KeptHistory& kept_;
  const JobHistory& recent_;
};

}  // namespace contourd
