// Detects the end of contourctl watch: the end of the current print, or of one job, which may still be in the
// queue. Asks contourd, and does not draw.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "daemon/client/daemon_connection.hpp"

namespace contourd::ctl {

class WatchEnd {
 public:
  using Json = DaemonConnection::Json;

  // `job`: name of the job or its file; nullopt: the current print.
  explicit WatchEnd(const std::optional<std::string>& job);

  // Sends the first requests on a new connection, and forgets the state from an earlier one.
  void begin(DaemonConnection& connection);
  // Requests the facts that contourd does not send by itself. To be called every kAskInterval.
  static constexpr std::chrono::milliseconds kAskInterval{500};
  void ask_again(DaemonConnection& connection) const;

  // Handles a message. Returns the ended job, in the form of a status, if the message reports its end. Throws
  // NoSuchJob.
  [[nodiscard]] std::optional<Json> take(const Json& message);

  struct NoSuchJob {
    std::string sentence;
  };

  // Return the status or the queue in a message, or nullptr if it contains none.
  [[nodiscard]] static const Json* status_in(const Json& message);
  [[nodiscard]] static const Json* queue_in(const Json& message);
  // True for an answer to ask_again(), which is not shown to the user.
  [[nodiscard]] static bool is_repeated(const Json& message);

  // Returns the awaited job; empty: the current print.
  [[nodiscard]] const std::string& job() const { return job_; }
  // True if contourd has reported this job so far.
  [[nodiscard]] bool is_known() const { return job_.empty() || is_known_; }
  // True if the awaited job is being printed, according to the last status.
  [[nodiscard]] bool is_under_way() const { return is_under_way_; }

  void ask_status(DaemonConnection& connection) const;
  void ask_queue(DaemonConnection& connection) const;

 private:
  void note_seen();
  // Notes whether the job is in the queue. Returns false if contourd has not known the job for some seconds.
  [[nodiscard]] bool note_queue(const Json& result);
  [[nodiscard]] std::optional<Json> end_in(const Json& history) const;

  std::string job_;
  std::string under_way_;  // name of the last job that was printed
  bool is_under_way_ = false, is_known_ = false;
  std::chrono::steady_clock::time_point last_seen_;
};

}  // namespace contourd::ctl
