// Cuts a print's masks ahead of time on a thread of its own, one at a time. The mask that was taken last
// stays while the next one is cut. Event loop's thread only. Holds two masks of the display's size, beside
// those of the engine.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>

#include "core/engine/contour_engine.hpp"
#include "core/geometry/mask_budget.hpp"
#include "hw/clock.hpp"

namespace contourd {

class MaskAhead {
 public:
  struct Cut {
    Mask mask;
    Nanometers height{};
    std::uint8_t white = 255;  // grey value of white pixels; darker ones are darkened in proportion
    double lit_area = 0;       // in pixels, as if white were white
    std::chrono::steady_clock::duration time{};
    std::string trouble{};  // a sentence: the mask could not be cut
  };

  // Returns the memory of the masks in bytes.
  [[nodiscard]] static std::uint64_t memory(const DisplayGeometry& display) {
    return 2 * static_cast<std::uint64_t>(display.width.count()) *
           static_cast<std::uint64_t>(display.height.count());
  }

  // The engine has no other user while this object lives. Engine and clock must outlive it. Throws
  // std::system_error (a thread).
  MaskAhead(ContourEngine& engine, const Clock& clock, Duration budget);
  ~MaskAhead();
  MaskAhead(const MaskAhead&) = delete;
  MaskAhead& operator=(const MaskAhead&) = delete;

  // Begins to cut the mask at a height, which replaces one that is ready and was not taken. REQUIRES:
  // !busy().
  void begin(Nanometers height, std::uint8_t white = 255);
  // True from begin() until take().
  [[nodiscard]] bool begun() const { return begun_; }
  // True from begin() until the mask is ready. If the clock skips all waiting, waits for that.
  [[nodiscard]] bool busy() const;
  // Returns the mask that is ready. Valid until the next take(). REQUIRES: !busy(), and begin() was called
  // since the last take().
  const Cut& take();
  // True if a mask is ready that was not taken.
  [[nodiscard]] bool ready() const { return begun_ && !busy(); }

 private:
  enum class Phase { Idle, Asked, Ended };
  void work();
  void cut(Cut& cut);

  ContourEngine& engine_;
  const Clock& clock_;
  Duration budget_;
  std::array<Cut, 2> cuts_;
  std::size_t taken_ = 0;  // of cuts_; the thread writes the other one while phase_ is Asked
  bool begun_ = false;     // since the last take()
  std::atomic<Phase> phase_{Phase::Idle};
  std::jthread thread_;  // last: joined before the members that it uses are destroyed
};

}  // namespace contourd
