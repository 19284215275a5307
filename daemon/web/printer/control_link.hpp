// Calls of contourd's methods over its control socket, without blocking: answers come by the event loop.
// Event loop's thread only.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/system/event_loop.hpp"

namespace contourd::web {

class ControlLink {
 public:
  using Json = DaemonConnection::Json;
  // Gets the answer, which has a "result" or an "error" with "code" and "message".
  using Answer = std::function<void(const Json& answer)>;
  using Notified = std::function<void(const Json& notification)>;

  static constexpr std::size_t kMostCalls = 64;  // calls that wait for their answers
  static constexpr std::chrono::seconds kPatience{15}, kLongPatience{120};
  static constexpr int kUnreachable = -32098;  // the error's code if contourd does not answer

  // Waits for each answer for at most `patience`.
  ControlLink(EventLoop& loop, std::filesystem::path socket, std::chrono::seconds patience = kPatience)
      : loop_(loop), socket_(std::move(socket)), patience_(patience) {}
  ControlLink(const ControlLink&) = delete;
  ControlLink& operator=(const ControlLink&) = delete;

  // Calls a method; connects first if necessary. `answer` is called later, exactly once; if contourd cannot
  // be reached or does not answer, with an error of the code kUnreachable.
  void call(Request request, Answer answer);
  // Calls `notified` for each notification that contourd sends.
  void on_notification(Notified notified) { notified_ = std::move(notified); }
  [[nodiscard]] bool is_connected() const { return connection_ != nullptr; }
  // Closes the connection; pending calls are answered with an error.
  void close(const std::string& why);

 private:
  struct Call {
    Request request;
    Answer answer;
  };

  void send_next();
  void receive();
  void take(const Json& message);
  void fail_later(Answer answer, std::string why);

  EventLoop& loop_;
  std::filesystem::path socket_;
  std::chrono::seconds patience_;
  std::unique_ptr<DaemonConnection> connection_;
  std::unique_ptr<EventLoop::IoSource> source_;
  EventLoop::SourcePtr patience_timer_, fail_timer_;
  std::deque<Call> calls_;  // the first is sent if asked_
  std::vector<std::pair<Answer, std::string>> failed_;
  bool asked_ = false;
  int number_ = 0;
  Notified notified_;
};

}  // namespace contourd::web
