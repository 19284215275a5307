// When contourctl watch has seen what it waits for: the end of the print under way, or of one job wherever it
// is. Asks contourd, and knows no screen.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "daemon/client/daemon_connection.hpp"

namespace contourd::ctl {

class WatchEnd {
 public:
  using Json = DaemonConnection::Json;

  // The file's or the job's name; nothing: whichever is printed.
  explicit WatchEnd(const std::optional<std::string>& job);

  // On a connection that is new. What was known from an earlier one may have changed meanwhile.
  void begin(DaemonConnection& connection);
  // To be called every kAskInterval: what contourd does not tell by itself.
  static constexpr std::chrono::milliseconds kAskInterval{500};
  void ask_again(DaemonConnection& connection) const;

  // The ended job, as a status has it, if this message says so. Throws NoSuchJob.
  [[nodiscard]] std::optional<Json> take(const Json& message);

  struct NoSuchJob {
    std::string sentence;
  };

  // Nothing where the message has none.
  [[nodiscard]] static const Json* status_in(const Json& message);
  [[nodiscard]] static const Json* queue_in(const Json& message);
  // Whether it is an answer to ask_again(): that is not for the user.
  [[nodiscard]] static bool is_repeated(const Json& message);

  // Empty: whichever is printed.
  [[nodiscard]] const std::string& job() const { return job_; }
  // Whether there is such a job, as far as contourd has said by now.
  [[nodiscard]] bool is_known() const { return job_.empty() || is_known_; }
  // Whether that is printed, by the last status.
  [[nodiscard]] bool is_under_way() const { return is_under_way_; }

  void ask_status(DaemonConnection& connection) const;
  void ask_queue(DaemonConnection& connection) const;

 private:
  void note_seen();
  // False when it is not there any more, or never was.
  [[nodiscard]] bool note_queue(const Json& result);
  [[nodiscard]] std::optional<Json> end_in(const Json& history) const;

  std::string job_;
  std::string under_way_;  // the last job under way
  bool is_under_way_ = false, is_known_ = false;
  std::chrono::steady_clock::time_point last_seen_;
};

}  // namespace contourd::ctl
