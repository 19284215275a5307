#include "core/mask/exposure_correction.hpp"

#include <cstring>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Returns ln(x) for 1/256 <= x <= 1, to 1e-15: x is doubled until it is at least 1/2, then 2 artanh((x - 1) /
// (x + 1)).
double natural_log(double x) {
  constexpr double kLn2 = 0.693147180559945309417;
  int halvings = 0;
  while (x < 0.5) {
    x *= 2;
    ++halvings;
  }
  const double y = (x - 1) / (x + 1), y2 = y * y;  // at most 1/9
  double sum = 0;
  for (int n = 41; n > 0; n -= 2)
    sum = sum * y2 + 1.0 / n;
  return 2 * y * sum - halvings * kLn2;
}

// Returns e^x for x <= 0: (e^(x/2^k))^(2^k), the inner power by its series.
double exponential(double x) {
  int squarings = 0;
  while (x < -0.125) {
    x /= 2;
    ++squarings;
  }
  double sum = 1;
  for (int n = 14; n > 0; --n)
    sum = 1 + x * sum / n;
  for (; squarings > 0; --squarings)
    sum *= sum;
  return sum;
}

bool of_one_size(const Mask& a, const Mask& b) {
  return a.width() == b.width() && a.height() == b.height();
}

}  // namespace

double power_of_share(double share, double exponent) {
  expects(1.0 / 256 <= share && share <= 1 && exponent > 0, "a share of the light is raised to a power");
  return exponential(natural_log(share) * exponent);
}

std::array<std::uint8_t, 256> grey_for_light(double gamma) {
  expects(kLeastGamma <= gamma && gamma <= kGreatestGamma, "gamma is 0.1 to 10");
  std::array<std::uint8_t, 256> table{};
  for (std::size_t light = 1; light < table.size(); ++light) {
    const double share = static_cast<double>(light) / 255.0;
    table[light] = static_cast<std::uint8_t>(255.0 * exponential(natural_log(share) / gamma) + 0.5);
  }
  return table;
}

ExposureCorrection::ExposureCorrection(const ToneCurve& tone, std::optional<Mask> uniformity)
    : tone_(tone), grey_for_light_(grey_for_light(tone.gamma)), uniformity_(std::move(uniformity)) {
  if (!uniformity_) return;
  white_ = uniformity_;
  for (std::int32_t y = 0; y < white_->height().count(); ++y) {
    for (std::uint8_t& grey : white_->row(y))
      grey = corrected(255, grey);
  }
}

std::uint8_t ExposureCorrection::corrected(std::uint8_t grey, std::uint8_t share) const {
  if (grey < tone_.threshold) return 0;
  return grey_for_light_[(static_cast<unsigned>(grey) * share + 127) / 255];
}

void ExposureCorrection::apply(const Mask& from, Mask& to) const {
  expects(&from != &to, "the corrected mask is another object than the mask");
  expects(of_one_size(from, to) && (!uniformity_ || of_one_size(from, *uniformity_)),
          "all masks have one size");
  // Eight pixels at a time where all are dark or all are white, as everywhere except along the contours.
  using Eight = std::uint64_t;
  constexpr Eight kWhite = ~Eight{0};
  const auto width = static_cast<std::size_t>(from.width().count());
  for (std::int32_t y = 0; y < from.height().count(); ++y) {
    const std::uint8_t* const in = from.row(y).data();
    std::uint8_t* const out = to.row(y).data();
    const std::uint8_t* const uniformity = uniformity_ ? uniformity_->row(y).data() : nullptr;
    const std::uint8_t* const white = white_ ? white_->row(y).data() : nullptr;
    const auto correct = [&](std::size_t x) {
      out[x] = corrected(in[x], uniformity != nullptr ? uniformity[x] : 255);
    };
    std::size_t x = 0;
    for (; x + sizeof(Eight) <= width; x += sizeof(Eight)) {
      Eight eight;
      std::memcpy(&eight, in + x, sizeof eight);
      if (eight == 0 || (eight == kWhite && white == nullptr)) {
        std::memcpy(out + x, &eight, sizeof eight);
      } else if (eight == kWhite) {
        std::memcpy(out + x, white + x, sizeof eight);
      } else {
        for (std::size_t i = x; i < x + sizeof eight; ++i)
          correct(i);
      }
    }
    for (; x < width; ++x)
      correct(x);
  }
}

}  // namespace contourd
