// The methods by which an owner's programs ask what became of their jobs. They know no transport. Event
// loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "daemon/control/control_method.hpp"
#include "daemon/history/history_worker.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/history/reminders.hpp"

namespace contourd {

class HistoryControl {
 public:
  using Json = ControlMethod::Json;
  // A reply's jobs.
  static constexpr std::size_t kLongestPage = 100;

  // All must outlive the control. `recent` is asked where the kept one cannot be; `replaced` is called when a
  // part was.
  HistoryControl(HistoryWorker& kept, const JobHistory& recent, Reminders& reminders,
                 std::function<void(WearPart)> replaced)
      : kept_(kept), recent_(recent), reminders_(reminders), replaced_(std::move(replaced)) {}

  // All of them, by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();
  // What it asked is not answered any more.
  void disconnected(std::uint64_t connection) { kept_.disconnected(connection); }

 private:
  std::optional<Json> history(const Json& given, const ControlCaller& caller, ControlMethod::Later later);
  std::optional<Json> usage(const ControlCaller& caller, ControlMethod::Later later);
  std::optional<Json> replace(const Json& given, const ControlCaller& caller, ControlMethod::Later later);
  [[nodiscard]] Json usage_reply(const std::optional<HistoryWorker::AllUsage>& usage,
                                 const std::string& trouble) const;

  HistoryWorker& kept_;
  const JobHistory& recent_;
  Reminders& reminders_;
  std::function<void(WearPart)> replaced_;
};

}  // namespace contourd
