// Sends a notice of each job that has ended to a stream socket: the service manager's
// contourd-job-ended.socket, which starts the user's command. contourd does not wait for that command, and
// the socket need not exist. Event loop's thread only; does not block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <list>
#include <string>

#include "daemon/history/job_history.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// Returns the notice of a job: environment variables NAME=VALUE, each followed by a zero byte. Values are
// single printable lines, except the report's paths, which are not changed. At most 60 kB.
[[nodiscard]] std::string notice_of(const EndedJob& job, const std::string& printer);

class EndedJobNotices {
 public:
  // Maximum number of open connections; each lasts until the other end closes it.
  static constexpr std::size_t kMostOpen = 4;
  // Maximum number of notices that wait for a connection. Further jobs get no notice, which is logged.
  static constexpr std::size_t kMostWaiting = 64;

  // Receives the key of a job whose notice was sent, or has no receiver. Called from the loop's thread.
  using Sent = std::function<void(std::int64_t key)>;

  // Loop and log must outlive the object. `socket` is the path of a stream socket.
  EndedJobNotices(EventLoop& loop, const Log& log, std::filesystem::path socket, std::string printer,
                  Sent sent);
  // Sends the waiting notices at once, beyond kMostOpen.
  ~EndedJobNotices();
  EndedJobNotices(const EndedJobNotices&) = delete;
  EndedJobNotices& operator=(const EndedJobNotices&) = delete;

  void add(const EndedJob& job);

 private:
  enum class Delivery { Taken, Busy, NoListener, Refused };
  struct Waiting {
    std::string notice;
    std::int64_t key = 0;  // of its job
  };
  struct Notice {
    FileDescriptor socket;
    std::unique_ptr<EventLoop::IoSource> end;
  };

  void hand_over();
  // Removes the first waiting notice, which needs no further attempt.
  void finish_first();
  // Sends a notice; `socket` becomes its connection if the result is Taken.
  [[nodiscard]] Delivery send(const std::string& notice, FileDescriptor& socket);
  void watch(FileDescriptor socket);
  void note_trouble(const std::string& trouble);

  EventLoop& loop_;
  const Log& log_;
  std::filesystem::path socket_;
  std::string printer_, trouble_;  // trouble_: the error that was logged last
  std::deque<Waiting> waiting_;
  Sent sent_;
  std::list<Notice> open_;
  bool too_many_logged_ = false;
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd
