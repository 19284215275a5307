// A straight move from rest to rest over time, within limits of speed, acceleration and, optionally, jerk:
// the mathematics that the profiles and the step planner share. Pure value, thread-safe; neither allocates
// nor throws, so that real-time threads may use it. One unit of length throughout (millimetres, steps).
//
// A ramp to speed v takes T = v/A + A/J where v >= A^2/J (the acceleration rises for A/J, holds, falls for
// A/J), else T = 2 sqrt(v/J) (rises, falls); without a jerk limit T = v/A. By symmetry its distance is v T /
// 2. A distance D too short for the top speed has its peak where v T(v) = D. The curve is at most seven
// pieces of constant jerk, within each of which x = x0 + v0 t + a0 t^2/2 + j t^3/6.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/rise_curve.hpp"

namespace contourd {

struct MotionLimits {
  double speed = 0;                                       // units/s
  double acceleration = 0;                                // units/s^2
  double jerk = std::numeric_limits<double>::infinity();  // units/s^3
};

class MotionCurve {
 public:
  MotionCurve() = default;  // a move of no distance and no duration
  // REQUIRES: distance >= 0; every limit > 0.
  MotionCurve(double distance, const MotionLimits& limits) noexcept;
  // Makes a move along a rise, which must outlive all copies; the limits are those of a stop. REQUIRES: every
  // limit > 0.
  MotionCurve(const RiseCurve& rise, const MotionLimits& limits) noexcept;

  [[nodiscard]] double duration_s() const noexcept { return end().start_s; }
  [[nodiscard]] double distance() const noexcept { return end().position; }

  // Return the position and the speed at a time; before the start and after the end, the curve is at rest.
  [[nodiscard]] double position_at(double seconds) const noexcept;
  [[nodiscard]] double speed_at(double seconds) const noexcept;

  // Returns the time at which the curve passes `position`: 0 for the start, duration_s() beyond the end.
  [[nodiscard]] double time_at(double position) const noexcept;

  // Brings the curve to rest as soon as the limits allow, from `seconds` on. Does nothing if the curve is
  // already slowing down to rest by then.
  void stop_at(double seconds) noexcept;

 private:
  struct State {
    double start_s = 0, position = 0, speed = 0, acceleration = 0;
  };
  struct Piece : State {
    double jerk = 0;  // constant within the piece
  };
  // Four pieces before a stop, one to let the acceleration fall, three to slow down.
  static constexpr std::size_t kMaxPieces = 8;

  [[nodiscard]] const State& end() const noexcept { return pieces_[count_]; }
  [[nodiscard]] bool follows_rise(double seconds) const noexcept {
    return rise_ != nullptr && seconds < pieces_[0].start_s;
  }
  [[nodiscard]] static State after(const Piece& piece, double seconds) noexcept;
  [[nodiscard]] std::size_t piece_at(double seconds) const noexcept;
  void add(double seconds, double acceleration, double jerk) noexcept;
  void add_ramp(double change, double sign) noexcept;
  void stop_from(const State& now) noexcept;

  MotionLimits limits_{};
  bool stopping_ = false;
  std::size_t count_ = 0;
  const RiseCurve* rise_ = nullptr;             // motion before the first piece; null if there is none
  std::array<Piece, kMaxPieces + 1> pieces_{};  // the entry after the last piece is the end
};

// The displacement of a straight move along a MotionCurve, upwards or downwards.
class MotionProfile {
 public:
  // Plans a move over `distance`, whose sign is the direction. The limits are those of a MotionCurve.
  MotionProfile(Nanometers distance, MillimetersPerSecond speed, MillimetersPerSecondSquared acceleration,
                std::optional<double> jerk_mm_s3 = std::nullopt);
  // Makes the displacement along a rise in millimetres, which must outlive it; a stop slows down by
  // `acceleration`.
  MotionProfile(const RiseCurve& rise, MillimetersPerSecondSquared acceleration);

  [[nodiscard]] Duration duration() const;

  // Returns the displacement `elapsed` after the start: 0 before the start, the whole distance after
  // duration().
  [[nodiscard]] Nanometers displacement(Duration elapsed) const;

  // Decelerates to a standstill from `elapsed` after the start on, which changes duration() and
  // displacement(). Does nothing if the move is already decelerating by then.
  void stop_at(Duration elapsed) { curve_.stop_at(in_seconds(elapsed)); }

 private:
  double sign_;
  MotionCurve curve_;  // in millimetres
};

}  // namespace contourd
