// A copy of the picture on the display, as a PNG for clients. The mask itself is copied, not computed again:
// some rows per turn of the event loop, so that no light has to wait. A worker's thread encodes the copy.
// Event loop's thread only.
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
    std::uint64_t number = 0;  // this and the following fields as in ShownMask
    std::string name;
    std::optional<std::int32_t> layer;
    Nanometers cut_at{};
    Pixels width{}, height{};
    std::vector<std::uint8_t> png;
  };
  // Receives the picture, or null and a clause with the reason why there is none.
  using Done = std::function<void(std::shared_ptr<const Picture>, const std::string& trouble)>;

  // Time for which a picture is kept for clients that read it in pieces.
  static constexpr Duration kKept = std::chrono::seconds(30);

  // `shown` returns the shown mask, which must stay valid until the loop's next turn. Loop and worker must
  // outlive the copy.
  ScreenCopy(EventLoop& loop, Worker& worker, std::function<ShownMask()> shown);

  // Calls `done` later from the event loop, in a turn of its own. Calls made meanwhile get the same picture.
  void take(Done done);
  // Returns the last picture if it has this number and is still kept, else null.
  [[nodiscard]] std::shared_ptr<const Picture> picture(std::uint64_t number);

 private:
  void begin(std::unique_ptr<Mask> copy);
  void copy_next();
  void copy_some();
  void encode();
  void finish(const std::shared_ptr<const Picture>& picture, const std::string& trouble);
  void answer_next();

  EventLoop& loop_;
  Worker& worker_;
  std::function<ShownMask()> shown_;
  std::vector<Done> waiting_;
  std::unique_ptr<Mask> copy_;  // while it is being copied
  Picture about_;               // the mask being copied; without PNG
  std::int32_t next_row_ = 0;
  int attempts_ = 0;
  std::shared_ptr<const Picture> latest_;
  std::deque<std::function<void()>> answers_;
  EventLoop::SourcePtr next_turn_, next_answer_, latest_end_;
  // Checked after a task of the worker, which may outlive the copy.
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace contourd
