// Writes the masks that a print's rise shows to a file, on a thread of its own: neither the event loop nor
// the print waits for the disk. A record for which there is no room, in memory or in the file, is lost and
// counted. Event loop's thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <string>

#include "daemon/frames/frame_record.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

// The frames of a print that is over.
struct EndedFrameLog {
  std::filesystem::path file{};  // empty: the print showed no frames, or none could be written
  std::uint64_t recorded = 0, lost = 0;
  std::string trouble{};  // why frames were lost; empty if none were
};

class FrameLog {
 public:
  // Removes a file that a print before has left. Makes it again with the first frames of a print.
  FrameLog(EventLoop& loop, std::filesystem::path file);
  ~FrameLog();
  FrameLog(const FrameLog&) = delete;
  FrameLog& operator=(const FrameLog&) = delete;

  // Adds a frame of the print under way. Never waits.
  void add(const FrameRecord& frame);
  // Ends the print's file. The result is ready when the file is complete; the file stays until it is removed
  // or the next print's first frames replace it.
  [[nodiscard]] std::shared_future<EndedFrameLog> end();

 private:
  class Disk;
  void write();

  std::shared_ptr<Disk> disk_;  // all but its ring is used by the worker's thread only
  std::uint64_t lost_ = 0;      // for which the ring had no room
  bool writing_ = false;
  Worker worker_;  // last: its thread ends before what its tasks use
};

}  // namespace contourd
