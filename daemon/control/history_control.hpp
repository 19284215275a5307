// The methods with which clients query the ended jobs and the use of the printer. Independent of the
// transport. Event loop's thread only.
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
  // Maximum number of jobs in a reply.
  static constexpr std::size_t kLongestPage = 100;

  // All arguments must outlive the control. `recent` is used while the history's file cannot be read. Calls
  // `replaced` after a part was replaced.
  HistoryControl(HistoryWorker& worker, const JobHistory& recent, Reminders& reminders,
                 std::function<void(WearPart)> replaced)
      : worker_(worker), recent_(recent), reminders_(reminders), replaced_(std::move(replaced)) {}

  // Returns all methods by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();
  // Drops the requests of a closed connection.
  void disconnected(std::uint64_t connection) { worker_.disconnected(connection); }

 private:
  void history(const Json& given, const ControlCaller& caller, ControlMethod::Later later);
  void usage(const ControlCaller& caller, ControlMethod::Later later);
  void replace(const Json& given, const ControlCaller& caller, ControlMethod::Later later);
  [[nodiscard]] Json usage_reply(const std::optional<HistoryWorker::AllUsage>& usage,
                                 const std::string& trouble) const;

  HistoryWorker& worker_;
  const JobHistory& recent_;
  Reminders& reminders_;
  std::function<void(WearPart)> replaced_;
};

}  // namespace contourd
