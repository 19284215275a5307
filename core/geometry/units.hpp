// Quantities that cross a function boundary, each with its own type, so that a mixed-up unit does not
// compile. Value types; thread-safe as any value is.
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>
#include <optional>

namespace contourd {

// A number with a unit, explicit to make and explicit to read: `Nanometers{2500}.count()`.
template <typename Unit, typename Rep>
class Quantity {
 public:
  using rep = Rep;

  constexpr Quantity() = default;
  constexpr explicit Quantity(Rep count) : count_(count) {}

  [[nodiscard]] constexpr Rep count() const { return count_; }

  constexpr auto operator<=>(const Quantity&) const = default;

  constexpr Quantity operator-() const { return Quantity(-count_); }
  constexpr Quantity& operator+=(Quantity other) {
    count_ += other.count_;
    return *this;
  }
  constexpr Quantity& operator-=(Quantity other) {
    count_ -= other.count_;
    return *this;
  }
  friend constexpr Quantity operator+(Quantity a, Quantity b) { return Quantity(a.count_ + b.count_); }
  friend constexpr Quantity operator-(Quantity a, Quantity b) { return Quantity(a.count_ - b.count_); }
  friend constexpr Quantity operator*(Quantity a, Rep factor) { return Quantity(a.count_ * factor); }
  friend constexpr Quantity operator*(Rep factor, Quantity a) { return Quantity(a.count_ * factor); }
  friend constexpr Quantity operator/(Quantity a, Rep divisor) { return Quantity(a.count_ / divisor); }
  friend constexpr Rep operator/(Quantity a, Quantity b) { return a.count_ / b.count_; }

 private:
  Rep count_{};
};

// Heights of the plate, in whole nanometres: an 8 mm screw at 3200 microsteps a turn moves 2.5 um a step, so
// whole micrometres would drift.
using Nanometers = Quantity<struct NanometerUnit, std::int64_t>;
// Whole microsteps of an axis' motor.
using Microsteps = Quantity<struct MicrostepUnit, std::int64_t>;
// Coordinates and lengths of a model, in the unit of its file.
using Millimeters = Quantity<struct MillimeterUnit, double>;
using Micrometers = Quantity<struct MicrometerUnit, double>;
using MillimetersPerSecond = Quantity<struct MillimeterPerSecondUnit, double>;
using MillimetersPerSecondSquared = Quantity<struct MillimeterPerSecondSquaredUnit, double>;
// Light that a square centimetre received, and the rate at which it does.
using MillijoulesPerCm2 = Quantity<struct MillijoulePerCm2Unit, double>;
using MilliwattsPerCm2 = Quantity<struct MilliwattPerCm2Unit, double>;
// Whole display pixels.
using Pixels = Quantity<struct PixelUnit, std::int32_t>;

[[nodiscard]] constexpr Millimeters to_millimeters(Nanometers height) {
  return Millimeters{static_cast<double>(height.count()) / 1e6};
}

[[nodiscard]] constexpr Millimeters to_millimeters(Micrometers length) {
  return Millimeters{length.count() / 1e3};
}

[[nodiscard]] constexpr double in_mm(Nanometers height) {
  return to_millimeters(height).count();
}

// Rounds to the nearest nanometre. Returns nullopt if the length is not a number, or beyond 9,000 km, where
// int64 would overflow.
[[nodiscard]] inline std::optional<Nanometers> to_nanometers(Millimeters length) {
  if (!(std::fabs(length.count()) <= 9e12)) return std::nullopt;
  return Nanometers{std::llround(length.count() * 1e6)};
}

}  // namespace contourd
