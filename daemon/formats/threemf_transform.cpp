#include "daemon/formats/threemf_transform.hpp"

#include <charconv>
#include <cmath>

#include "core/model/model.hpp"

namespace contourd {

double ThreeMfTransform::determinant() const {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

Vertex ThreeMfTransform::operator()(const Vertex& vertex) const {
  const double x = vertex.x, y = vertex.y, z = vertex.z;
  const auto along = [&](std::size_t axis) {
    return static_cast<float>(x * m[axis] + y * m[3 + axis] + z * m[6 + axis] + m[9 + axis]);
  };
  return {along(0), along(1), along(2)};
}

ThreeMfTransform combined(const ThreeMfTransform& first, const ThreeMfTransform& second) {
  ThreeMfTransform both;
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      double sum = row == 3 ? second.m[9 + column] : 0;
      for (std::size_t i = 0; i < 3; ++i)
        sum += first.m[3 * row + i] * second.m[3 * i + column];
      both.m[3 * row + column] = sum;
    }
  }
  return both;
}

ThreeMfTransform parse_transform(std::string_view text) {
  ThreeMfTransform transform;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  const auto skip_blanks = [&] {
    while (at != end && (*at == ' ' || (*at >= '\t' && *at <= '\r')))
      ++at;
  };
  for (double& number : transform.m) {
    skip_blanks();
    if (at != end && *at == '+') ++at;
    const auto [after, error] = std::from_chars(at, end, number);
    if (error != std::errc{} || !std::isfinite(number))
      throw ModelError("a transform is not 12 finite numbers: export the model again");
    at = after;
  }
  skip_blanks();
  if (at != end) throw ModelError("a transform has more than 12 numbers: export the model again");
  return transform;
}

}  // namespace contourd
