// A model of the screen, which knows the visible picture and the refresh from which on it is visible. Reports
// to the loop unless an event is lost. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "hw/mask_display.hpp"
#include "tests/hw/plain_devices.hpp"
#include "tests/rig/loop.hpp"

namespace contourd::rig {

class DisplayModel final : public testing::PlainDisplay {
 public:
  using Picture = std::optional<int>;  // number of the mask; nullopt: black

  DisplayModel(VirtualClock& world, Loop& loop, Pixels width, Pixels height)
      : world_(world), loop_(loop), width_(width), height_(height) {}

  // Returns the number of the next mask shown.
  std::function<int()> number = [] { return 0; };
  std::function<void()> changed = [] {};

  [[nodiscard]] const Picture& picture() const { return picture_; }
  // Returns the number of pixels of the picture that are not dark.
  [[nodiscard]] std::int64_t lit_pixels() const { return picture_ ? lit_pixels_ : 0; }
  [[nodiscard]] bool there() const { return there_; }
  // Returns how often the picture was replaced.
  [[nodiscard]] std::uint64_t flips() const { return flips_; }
  // True if something was shown since the screen was plugged in. Before that it is black, and whoever lights
  // through it may not know yet.
  [[nodiscard]] bool in_use() const { return there_ && in_use_; }

  void lose_next_event() { loses_event_ = true; }
  void lose_next_flip() { loses_flip_ = true; }
  void unplug() {
    there_ = in_use_ = false;
    picture_.reset();
    changed();
    answer(std::nullopt);
  }
  void plug() { there_ = true; }

  [[nodiscard]] Pixels width() const override { return width_; }
  [[nodiscard]] Pixels height() const override { return height_; }
  [[nodiscard]] Duration frame() const override { return kFrame; }
  void show(const Mask& mask, Presented done) override { put(number(), std::move(done), mask.lit_pixels()); }
  void black(Presented done) override { put(std::nullopt, std::move(done)); }
  void black_now() noexcept override {
    done_ = nullptr;
    flip_ = world_.call_at(next_refresh(), [this] { flip(std::nullopt); });
  }

  // A missing flip is reported after this time.
  static constexpr Duration kFlipDeadline{std::chrono::milliseconds{500}};
  static constexpr Duration kFrame{16'666'667};

 private:
  [[nodiscard]] TimePoint next_refresh() const {
    return TimePoint{
        Duration{(world_.now().time_since_epoch().count() / kFrame.count() + 1) * kFrame.count()}};
  }
  void put(Picture picture, Presented done, std::int64_t lit_pixels = 0) {
    done_ = std::move(done);
    ++requests_;
    if (!there_) return answer(std::nullopt);
    if (std::exchange(loses_flip_, false)) {
      lost_ = world_.call_after(kFlipDeadline, [this] { answer(std::nullopt); });
      return;
    }
    flip_ = world_.call_at(next_refresh(), [this, picture, lit_pixels] {
      lit_pixels_ = lit_pixels;
      flip(picture);
      if (!std::exchange(loses_event_, false)) answer(world_.now());
    });
  }
  void flip(Picture picture) {
    if (!there_) return;
    in_use_ = true;
    ++flips_;
    picture_ = picture;
    changed();
  }
  void answer(std::optional<TimePoint> at) {
    event_ = world_.call_after(Duration{0}, [this, at, request = requests_] {
      loop_.post([this, at, request] {
        if (request != requests_) return;
        if (const auto done = std::exchange(done_, nullptr)) done(at);
      });
    });
  }

  VirtualClock& world_;
  Loop& loop_;
  Pixels width_, height_;
  Picture picture_;
  std::int64_t lit_pixels_ = 0;
  Presented done_;
  std::uint64_t requests_ = 0, flips_ = 0;
  bool there_ = true, in_use_ = true, loses_event_ = false, loses_flip_ = false;
  std::unique_ptr<Timer> flip_, event_, lost_;
};

}  // namespace contourd::rig
