// Tells whoever the owner has listen on a socket of each job that has ended: contourd-job-ended.socket of the
// service manager, which starts the owner's command. Nobody waits for that command, and nobody need listen.
// Event loop's thread only; does not block.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <list>
#include <string>

#include "daemon/history/job_history.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// What is told of a job: NAME=VALUE for an environment, each ended by a zero byte. Values are single lines
// fit for a person, but for the report's paths, which are what they are. At most 60 kB.
[[nodiscard]] std::string notice_of(const EndedJob& job, const std::string& printer);

class EndedJobNotices {
 public:
  // So many are told of at a time; each lasts until the other end closes it.
  static constexpr std::size_t kMostOpen = 4;
  // So many wait for that. Beyond it a job ends without a notice, which is logged.
  static constexpr std::size_t kMostWaiting = 64;

  // All must outlive it. `socket` is the path of a stream socket.
  EndedJobNotices(EventLoop& loop, const Log& log, std::filesystem::path socket, std::string printer);
  // Those that wait are handed over now, whoever waits for their end.
  ~EndedJobNotices();
  EndedJobNotices(const EndedJobNotices&) = delete;
  EndedJobNotices& operator=(const EndedJobNotices&) = delete;

  void add(const EndedJob& job);

 private:
  enum class Sent { Taken, Busy, NobodyListens, Refused };
  struct Notice {
    FileDescriptor socket;
    std::unique_ptr<EventLoop::IoSource> end;
  };

  void hand_over();
  // `socket` is the notice's once it is taken.
  [[nodiscard]] Sent send(const std::string& notice, FileDescriptor& socket);
  void watch(FileDescriptor socket);
  void note_trouble(const std::string& trouble);

  EventLoop& loop_;
  const Log& log_;
  std::filesystem::path socket_;
  std::string printer_, trouble_;  // the latter is told already
  std::deque<std::string> waiting_;
  std::list<Notice> open_;
  bool too_many_told_ = false;
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd
