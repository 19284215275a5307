// What the display shows, as a PNG for whoever asks for it. The mask itself is copied, not computed again: a
// little of it a turn of the loop, since a light may wait. It is encoded on a worker's thread. Event loop's
// thread only.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mask/mask.hpp"
#include "daemon/print/shown_mask.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

class ScreenCopy {
 public:
  struct Picture {
    std::uint64_t number = 0;  // this and the next ones as ShownMask has them
    std::string name;
    std::optional<std::int32_t> layer;
    Nanometers cut_at{};
    Pixels width{}, height{};
    std::vector<std::uint8_t> png;
  };
  // The picture, or null and a clause that says why there is none.
  using Done = std::function<void(std::shared_ptr<const Picture>, const std::string& trouble)>;

  // How long a picture is kept for those who read it in pieces.
  static constexpr Duration kKept = std::chrono::seconds(30);

  // `shown` tells the mask, which must be valid until the loop's next turn. Loop and worker must outlive the
  // copy.
  ScreenCopy(EventLoop& loop, Worker& worker, std::function<ShownMask()> shown);

  // Calls `done` later, from the loop, in a turn of its own. All who ask meanwhile get the same picture.
  void take(Done done);
  // The one taken last, if it is that mask's. Null where it is not, or not any more.
  [[nodiscard]] std::shared_ptr<const Picture> picture(std::uint64_t number);

 private:
  void begin(std::unique_ptr<Mask> room);
  void copy_next();
  void copy_some();
  void encode();
  void finish(const std::shared_ptr<const Picture>& picture, const std::string& trouble);
  void tell_next();

  EventLoop& loop_;
  Worker& worker_;
  std::function<ShownMask()> shown_;
  std::vector<Done> waiting_;
  std::unique_ptr<Mask> copy_;  // while it is being copied
  Picture about_;               // without its PNG
  std::int32_t next_row_ = 0;
  int attempts_ = 0;
  std::shared_ptr<const Picture> latest_;
  std::deque<std::function<void()>> to_tell_;
  EventLoop::SourcePtr next_turn_, next_telling_, latest_end_;
  // Behind a task of the worker's, which may outlive the copy.
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace contourd
