#include "daemon/control/screen_copy.hpp"

#include <algorithm>
#include <chrono>
#include <new>
#include <span>
#include <utility>

#include "core/image/mask_png.hpp"

namespace contourd {
namespace {

// Bytes copied in one turn of the loop; takes about 0.2 ms on a Raspberry Pi 3.
constexpr std::int32_t kBytesATurn = 262'144;
// Maximum number of masks that are begun to be copied, if each changes before it is complete.
constexpr int kMostAttempts = 10;
constexpr const char* kNoMemory = "not enough memory for the picture";

}  // namespace

ScreenCopy::ScreenCopy(EventLoop& loop, Worker& worker, std::function<ShownMask()> shown)
    : loop_(loop), worker_(worker), shown_(std::move(shown)) {}

std::shared_ptr<const ScreenCopy::Picture> ScreenCopy::picture(std::uint64_t number) {
  if (!latest_ || latest_->number != number) return nullptr;
  latest_end_ =
      loop_.at(std::chrono::steady_clock::now() + kKept, "the screen's picture", [this] { latest_.reset(); });
  return latest_;
}

void ScreenCopy::take(Done done) {
  waiting_.push_back(std::move(done));
  if (waiting_.size() > 1) return;
  const ShownMask shown = shown_();
  // Allocating a large mask also zeroes it, which takes time, so the worker does it.
  const auto allocate = [has_mask = shown.mask != nullptr,
                         width = shown.mask != nullptr ? shown.mask->width() : Pixels{},
                         height = shown.mask != nullptr ? shown.mask->height() : Pixels{}] {
    try {
      return has_mask ? std::make_unique<Mask>(width, height) : nullptr;
    } catch (const std::bad_alloc&) {
      return std::unique_ptr<Mask>();
    }
  };
  worker_.run(allocate, [this, alive = std::weak_ptr(alive_)](std::unique_ptr<Mask> copy) {
    if (!alive.expired()) begin(std::move(copy));
  });
}

void ScreenCopy::begin(std::unique_ptr<Mask> copy) {
  if (!copy) return finish(nullptr, shown_().mask != nullptr ? kNoMemory : "nothing is shown");
  copy_ = std::move(copy);
  about_ = {};
  attempts_ = 0;
  copy_next();
}

// Schedules the next rows; calls of the machine that are due come first.
void ScreenCopy::copy_next() {
  next_turn_ = loop_.at(std::chrono::steady_clock::now(), "a copy of the screen", [this] { copy_some(); });
}

void ScreenCopy::copy_some() {
  const ShownMask shown = shown_();
  if (shown.mask == nullptr || shown.mask->width() != copy_->width() ||
      shown.mask->height() != copy_->height()) {
    return finish(nullptr, "nothing is shown");
  }
  if (shown.number != about_.number) {
    if (++attempts_ > kMostAttempts)
      return finish(nullptr, "the masks change faster than they can be copied");
    about_ = {shown.number,   std::string(shown.name), shown.layer, shown.cut_at,
              copy_->width(), copy_->height(),         {}};
    next_row_ = 0;
  }
  const std::int32_t width = copy_->width().count(), height = copy_->height().count();
  const std::int32_t end = std::min(height, next_row_ + std::max(1, kBytesATurn / width));
  for (; next_row_ < end; ++next_row_)
    std::ranges::copy(shown.mask->row(next_row_), copy_->row(next_row_).begin());
  if (next_row_ < height) return copy_next();
  encode();
}

void ScreenCopy::encode() {
  const auto task = [mask = std::shared_ptr<const Mask>(std::move(copy_)), about = about_] {
    auto picture = std::make_shared<Picture>(about);
    try {
      MaskPngEncoder encoder;
      const std::span<const std::uint8_t> bytes = encoder.encode(*mask);
      picture->png.assign(bytes.begin(), bytes.end());
    } catch (const std::bad_alloc&) {
      picture.reset();
    }
    return picture;
  };
  worker_.run(task, [this, alive = std::weak_ptr(alive_)](const std::shared_ptr<const Picture>& picture) {
    if (!alive.expired()) finish(picture, picture ? "" : kNoMemory);
  });
}

void ScreenCopy::finish(const std::shared_ptr<const Picture>& picture, const std::string& trouble) {
  copy_.reset();
  latest_ = picture;
  if (latest_) (void)this->picture(latest_->number);
  const bool answering = !answers_.empty();
  for (Done& done : std::exchange(waiting_, {}))
    answers_.emplace_back([done = std::move(done), picture, trouble] { done(picture, trouble); });
  if (!answering) answer_next();
}

// Gives one answer per turn, because an answer is long and a light may be on.
void ScreenCopy::answer_next() {
  if (answers_.empty()) return;
  next_answer_ = loop_.at(std::chrono::steady_clock::now(), "a copy of the screen", [this] {
    const std::function<void()> answer = std::move(answers_.front());
    answers_.pop_front();
    answer_next();
    answer();
  });
}

}  // namespace contourd
