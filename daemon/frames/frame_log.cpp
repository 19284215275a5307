#include "daemon/frames/frame_log.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "daemon/frames/frame_file.hpp"
#include "daemon/frames/frame_ring.hpp"

namespace contourd {
namespace {

// Writing gives way to the event loop and to the masks' thread.
constexpr int kFramesNiceness = 10;

}  // namespace

class FrameLog::Disk {
 public:
  explicit Disk(std::filesystem::path path) : path_(std::move(path)) {}

  FrameRing ring;

  void remove() const {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

  // Writes the whole blocks that are in the ring; with `all`, also the last one.
  void write(bool all) {
    while (ring.size() >= (all ? 1 : block_.size())) {
      const std::size_t taken = ring.take(block_);
      const std::size_t room = FrameFile::kMostRecords - (writer_ ? writer_->records() : 0);
      const std::size_t fit = trouble_.empty() ? std::min(taken, room) : 0;
      lost_ += taken - fit;
      if (fit > 0) add(std::span(block_).first(fit));
    }
  }

  // Ends the file; the next frames begin another one.
  EndedFrameLog end(std::uint64_t lost_before) {
    write(true);
    lost_ += lost_before;
    EndedFrameLog ended;
    if (writer_ && trouble_.empty()) attempt([&] { writer_->finish(lost_); });
    if (writer_) ended = {path_, writer_->records()};
    ended.lost = lost_;
    ended.trouble = !trouble_.empty() ? trouble_
                    : lost_before > 0 ? "the disk was slower than the print"
                    : lost_ > 0       ? "the file is full"
                                      : "";
    writer_.reset();
    trouble_.clear();
    lost_ = 0;
    return ended;
  }

 private:
  void add(std::span<const FrameRecord> records) {
    const bool written = attempt([&] {
      if (!writer_) writer_.emplace(path_);
      writer_->add(records);
    });
    if (!written) lost_ += records.size();
  }

  template <typename Write>
  bool attempt(const Write& write) {
    try {
      write();
      return true;
    } catch (const std::exception& error) {
      trouble_ = error.what();
      return false;
    }
  }

  std::filesystem::path path_;
  std::array<FrameRecord, FrameFile::kBlockRecords> block_{};
  std::optional<FrameFileWriter> writer_;
  std::uint64_t lost_ = 0;
  std::string trouble_;
};

FrameLog::FrameLog(EventLoop& loop, std::filesystem::path file)
    : disk_(std::make_shared<Disk>(std::move(file))), worker_(loop, "contourd-frames", kFramesNiceness) {
  worker_.run(
      [disk = disk_] {
        disk->remove();
        return true;
      },
      [](bool) {});
}

FrameLog::~FrameLog() = default;

void FrameLog::add(const FrameRecord& frame) {
  if (!disk_->ring.add(frame)) ++lost_;
  write();
}

void FrameLog::write() {
  if (writing_ || disk_->ring.size() < FrameFile::kBlockRecords) return;
  writing_ = true;
  worker_.run(
      [disk = disk_] {
        disk->write(false);
        return true;
      },
      [this](bool) {
        writing_ = false;
        write();
      });
}

std::shared_future<EndedFrameLog> FrameLog::end() {
  auto ended = std::make_shared<std::promise<EndedFrameLog>>();
  std::shared_future<EndedFrameLog> result = ended->get_future().share();
  worker_.run(
      [disk = disk_, ended = std::move(ended), lost = std::exchange(lost_, 0)] {
        ended->set_value(disk->end(lost));
        return true;
      },
      [](bool) {});
  return result;
}

}  // namespace contourd
