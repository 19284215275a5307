#include "core/mask/exact_side.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// A number as the sum of two doubles: the result of an operation, and its rounding error.
struct Split {
  double sum, rest;
};

Split exact_sum(double a, double b) {
  const double sum = a + b;
  const double b_taken = sum - a;
  return {sum, (a - (sum - b_taken)) + (b - b_taken)};
}

Split exact_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// A sum of doubles that do not overlap, smallest first: its sign is the sign of the largest.
class Expansion {
 public:
  void add(double term) {
    for (std::size_t i = 0; i < size_; ++i) {
      const Split split = exact_sum(term, terms_[i]);
      terms_[i] = split.rest;
      term = split.sum;
    }
    terms_[size_++] = term;
  }
  void add_product(Split a, Split b, double sign) {
    for (const double x : {a.rest, a.sum}) {
      for (const double y : {b.rest, b.sum}) {
        const Split product = exact_product(x, y);
        add(sign * product.rest);
        add(sign * product.sum);
      }
    }
  }
  [[nodiscard]] int sign() const {
    for (std::size_t i = size_; i-- > 0;) {
      if (terms_[i] != 0) return terms_[i] > 0 ? 1 : -1;
    }
    return 0;
  }

 private:
  std::array<double, 16> terms_{};
  std::size_t size_ = 0;
};

bool is_exact(PixelPoint point) {
  constexpr double kMost = 1e100;
  return std::fabs(point.x) < kMost && std::fabs(point.y) < kMost;
}

}  // namespace

int side_of(PixelPoint a, PixelPoint b, PixelPoint point) {
  expects_costly([&] { return is_exact(a) && is_exact(b) && is_exact(point); },
                 "coordinates are below 1e100");
  const double left = (b.x - a.x) * (point.y - a.y), right = (b.y - a.y) * (point.x - a.x);
  // Bound on four roundings before the subtraction and its own: beyond it they cannot change the sign.
  constexpr double kRounding = 4.5e-16;
  const double difference = left - right;
  if (std::fabs(difference) > kRounding * (std::fabs(left) + std::fabs(right)))
    return difference > 0 ? 1 : -1;
  Expansion expansion;
  expansion.add_product(exact_sum(b.x, -a.x), exact_sum(point.y, -a.y), 1);
  expansion.add_product(exact_sum(b.y, -a.y), exact_sum(point.x, -a.x), -1);
  return expansion.sign();
}

}  // namespace contourd
