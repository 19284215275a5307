#include "core/model/sine_cosine.hpp"

#include <cmath>
#include <numbers>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// The Taylor series for x up to pi / 4, where the first term left out (x^19 / 19! and x^18 / 18!) is below
// 3e-18. Uses only additions, multiplications and divisions, each of which IEEE 754 fixes to the bit.
double sine_of(double x) {
  const double x2 = x * x;
  double sum = 0;
  for (int n = 16; n >= 2; n -= 2)
    sum = x2 / -(n * (n + 1)) * (1 + sum);
  return x + x * sum;
}

double cosine_of(double x) {
  const double x2 = x * x;
  double sum = 0;
  for (int n = 15; n >= 3; n -= 2)
    sum = x2 / -(n * (n + 1)) * (1 + sum);
  // 1 - x^2 / 2 is rounded; the rounding error is added with the rest.
  const double half = x2 / 2;
  const double rounded = 1 - half;
  return rounded + (((1 - rounded) - half) - half * sum);
}

}  // namespace

SineCosine sine_cosine(double degrees) {
  expects(std::isfinite(degrees), "the angle is finite");
  // std::remainder() is exact. `rest` lies within an eighth of a turn on either side of a quarter turn.
  const double turned = std::remainder(degrees, 360.0);
  const double rest = std::remainder(turned, 90.0);
  const int quarters = static_cast<int>((turned - rest) / 90.0);
  const double radians = rest * (std::numbers::pi / 180.0);
  const double sine = sine_of(radians), cosine = cosine_of(radians);
  switch (quarters) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case -1:
      return {-cosine, sine};
    default:
      return {-sine, -cosine};
  }
}

}  // namespace contourd
