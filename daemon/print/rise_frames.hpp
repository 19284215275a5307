// The masks of a rise: for each refresh of the display the one for the height at which resin gels at the
// middle of that refresh, which follows from the plate's height and the light so far (GelFront), cut on a
// thread of its own; the event loop never waits for it. A mask is cut when one of the two heights will have
// changed by `mask_step`, and passed to the display half a refresh before the vblank. Then the next one is
// begun, so that a mask has a whole refresh. A mask that is not ready by then is missed: the shown one stays.
// Event loop's thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/continuous/gel_front.hpp"
#include "daemon/frames/frame_record.hpp"
#include "daemon/print/mask_ahead.hpp"
#include "daemon/print/print_plan.hpp"
#include "daemon/print/shown_mask.hpp"
#include "hw/machine.hpp"

namespace contourd {

class RiseFrames {
 public:
  // The light may not shine while the plate is further than this from where the mask on the screen was due.
  static constexpr Nanometers kFarthest{5'000};
  // Nor while the mask's cut is further than this from the height at which resin gels: after a pause or a
  // rest that height follows the plate from further below, faster than the plate rises.
  static constexpr Nanometers kFarthestCut = 3 * kFarthest;

  // The part beneath the height `solid` is printed. All other arguments must outlive the object, and nothing
  // else may use the plan's engine meanwhile. If the plan's bounds do not say which resin is lit, it counts
  // as gelled up to the plate. Throws std::system_error (a thread).
  RiseFrames(Machine& machine, Clock& clock, const PrintPlan& plan, Nanometers solid);

  // Callbacks. Each may call stop().
  struct Calls {
    std::function<void()> refreshed;                 // a refresh has begun, or will within half of one
    std::function<void()> missed;                    // a mask was missed
    std::function<void(const std::string&)> unsafe;  // a sentence: the light must go off now
    // A mask has left the screen, or is the last one when stop() is called. Its layer is unknown.
    std::function<void(const FrameRecord&)> frame_over{};
    std::optional<TimePoint> lit_from{};  // since when there is light; nullopt: there is none
    Nanometers highest{std::numeric_limits<std::int64_t>::max()};  // bound of the cuts
  };
  // Shows the mask for the plate at rest, then calls `shown`. Stops what is under way.
  void show_first(std::function<void()> shown, std::function<void(const std::string&)> unsafe);
  // Shows a mask for each refresh from now on, until stop(); to be called when the first mask is on the
  // screen.
  void run(Calls calls);
  // Shows no further mask, and makes no further call. Liquid loses the dose that it has got.
  void stop();

  // Returns the height up to which resin has gelled; nullopt if the plate's position is unknown.
  [[nodiscard]] std::optional<Nanometers> gelled() const;

  // Gives white pixels this grey value from the next mask on, which comes with the next refresh; and returns
  // true if the mask on the screen has it.
  void set_white(std::uint8_t white) { white_.wanted = white; }
  [[nodiscard]] bool shows_white() const { return white_.on_screen == white_.wanted; }

  // Returns the mask that was passed to the display last.
  [[nodiscard]] const ShownMask& shown() const { return shown_; }
  // Returns the mean lit area, in pixels, of the masks since the last call, or that of the last mask.
  [[nodiscard]] double take_lit_pixels();
  // Counts a slower rise for a missed mask.
  void note_slower() { ++figures_.slowed; }
  // Returns the figures since the last call.
  [[nodiscard]] FrameFigures take_figures() { return std::exchange(figures_, {}); }

 private:
  void await_first(std::function<void()> shown);
  void present(std::function<void(TimePoint)> presented);
  void refresh();
  void begin_mask(TimePoint vblank);
  void hand_over(TimePoint vblank);
  void tell_missed(std::uint32_t frames);
  void begin_frame(TimePoint shown);
  void end_frame(TimePoint until);
  [[nodiscard]] TimePoint next_vblank() const;
  [[nodiscard]] GelFront::Light light_until(TimePoint when) const;
  void count_light();
  [[nodiscard]] std::optional<Nanometers> section_at(TimePoint when) const;

  Machine& machine_;
  Clock& clock_;
  const PrintPlan& plan_;
  MaskAhead masks_;
  Calls calls_;
  ShownMask shown_;
  struct Gelling {
    std::optional<GelFront> front;
    std::optional<TimePoint> lit_until;  // the time up to which the front has its light, while there is light
  } gelling_;
  struct Screen {
    Nanometers cut{};    // height of the cut of the mask on the screen
    Nanometers due{};    // height of the plate for which that mask was made
    Nanometers plate{};  // height of the plate for which a mask was passed to the display last
    TimePoint vblank{};  // a refresh, from which the others are counted
  } screen_;
  struct LitPixels {
    double last = 0;         // of the last mask
    double sum = 0;          // of the masks since the last take_lit_pixels()
    std::int64_t masks = 0;  // in the sum
  } lit_pixels_;
  struct White {
    std::uint8_t wanted = 255;
    std::uint8_t passed = 255;     // of the mask that was passed to the display last
    std::uint8_t on_screen = 255;  // of the mask on the screen
  } white_;
  FrameFigures figures_;
  std::optional<FrameRecord> frame_;  // the mask that is on the screen
  std::uint64_t stops_ = 0;           // answers of the display from before the last stop are ignored
  std::unique_ptr<Timer> refresh_, hand_over_;
};

}  // namespace contourd
