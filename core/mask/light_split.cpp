#include "core/mask/light_split.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/mask/exposure_correction.hpp"

namespace contourd {
namespace {

// Half a step of this many is kExactness of the light, even between black and white.
constexpr std::size_t kMostSteps = 50;
static_assert(1.0 / (2 * kMostSteps) <= LightSplit::kExactness);
// With these steps, a few shares are exact in few pictures if they are far enough apart.
constexpr std::size_t kFinestSteps = 255;
// A refresh lasts whole nanoseconds, which its share of an exposure shows.
constexpr double kRounding = 1e-6;

using Eight = std::uint64_t;
constexpr Eight kWhite = ~Eight{0};

// True if these eight pixels are all dark or all white.
bool are_plain(const std::uint8_t* pixels) {
  Eight eight;
  std::memcpy(&eight, pixels, sizeof eight);
  return eight == 0 || eight == kWhite;
}

// True if these are two objects of one size.
bool are_alike(const Mask& a, const Mask& b) {
  return &a != &b && a.width() == b.width() && a.height() == b.height();
}

std::array<bool, 256> values_of(const Mask& mask) {
  std::array<bool, 256> values{};
  const std::span<const std::uint8_t> pixels = mask.pixels();
  std::size_t i = 0;
  for (; i + sizeof(Eight) <= pixels.size(); i += sizeof(Eight)) {
    if (are_plain(&pixels[i])) continue;
    for (std::size_t of_eight = 0; of_eight < sizeof(Eight); ++of_eight)
      values[pixels[i + of_eight]] = true;
  }
  for (; i < pixels.size(); ++i)
    values[pixels[i]] = true;
  return values;
}

// Replaces values. Dark and white stay, which most pixels are.
void replace_values(const std::array<std::uint8_t, 256>& values, const Mask& from,
                    const LightSplit::Rows& rows, Mask& to) {
  const auto width = static_cast<std::size_t>(from.width().count());
  for (std::int32_t y = rows.first; y < rows.end; ++y) {
    const std::uint8_t* const in = from.row(y).data();
    std::uint8_t* const out = to.row(y).data();
    std::size_t x = 0;
    for (; x + sizeof(Eight) <= width; x += sizeof(Eight)) {
      if (are_plain(in + x)) {
        std::memcpy(out + x, in + x, sizeof(Eight));
      } else {
        for (std::size_t i = x; i < x + sizeof(Eight); ++i)
          out[i] = values[in[i]];
      }
    }
    for (; x < width; ++x)
      out[x] = values[in[x]];
  }
}

}  // namespace

LightSplit::LightSplit(const PanelTone& panel) {
  expects(1 <= panel.grey_bits && panel.grey_bits <= 7, "a panel has 1 to 7 grey bits");
  expects(0.1 <= panel.gamma && panel.gamma <= 10, "gamma is 0.1 to 10");
  const std::size_t greatest = (std::size_t{1} << panel.grey_bits) - 1;
  for (std::size_t level = 0; level <= greatest; ++level) {
    const double share = static_cast<double>(level) / static_cast<double>(greatest);
    levels_.push_back(level == 0 ? 0 : power_of_share(share, panel.gamma));
    greys_.push_back(static_cast<std::uint8_t>(255 * share + 0.5));
  }
  Values all;
  all.fill(true);
  for (std::size_t steps = 1; steps <= kMostSteps; ++steps) {
    add_division(steps);
    if (error_of(divisions_.back(), all) <= kExactness) break;
  }
  add_division(kFinestSteps);
  begins_.reserve(kFinestSteps);
  attempt_.reserve(kFinestSteps);
  begins_.push_back(0);
}

// A pixel shows the brighter of the two levels beside its share during the first steps, then the darker one.
void LightSplit::add_division(std::size_t step_count) {
  Division& division = divisions_.emplace_back();
  division.greys.resize(step_count);
  const auto steps = static_cast<double>(step_count);
  for (std::size_t light = 0; light < division.given.size(); ++light) {
    const double wanted = static_cast<double>(light) / 255;
    const auto above = std::ranges::upper_bound(levels_, wanted) - levels_.begin();
    const auto dim = static_cast<std::size_t>(above - 1), bright = std::min(dim + 1, levels_.size() - 1);
    const double range = levels_[bright] - levels_[dim];
    const double count = range > 0 ? std::floor((wanted - levels_[dim]) / range * steps + 0.5) : 0;
    division.given[light] = levels_[dim] + range * count / steps;
    for (std::size_t step = 0; step < division.greys.size(); ++step)
      division.greys[step][light] = greys_[static_cast<double>(step) < count ? bright : dim];
  }
}

double LightSplit::error_of(const Division& division, const Values& values) {
  double error = 0;
  for (std::size_t light = 0; light < values.size(); ++light)
    if (values[light])
      error = std::max(error, std::abs(division.given[light] - static_cast<double>(light) / 255));
  return error;
}

bool LightSplit::list_begins(const Division& division, const Values& values, double shortest,
                             std::vector<std::size_t>& begins) {
  const std::size_t steps = division.greys.size();
  const auto changes = [&](std::size_t step) {
    for (std::size_t light = 0; light < values.size(); ++light)
      if (values[light] && division.greys[step][light] != division.greys[step - 1][light]) return true;
    return false;
  };
  begins.assign(1, 0);
  for (std::size_t step = 1; step < steps; ++step)
    if (changes(step)) begins.push_back(step);
  const double least_steps = shortest * static_cast<double>(steps) * (1 - kRounding);
  for (std::size_t i = 0; i < begins.size() && begins.size() > 1; ++i) {
    const std::size_t end = i + 1 < begins.size() ? begins[i + 1] : steps;
    if (static_cast<double>(end - begins[i]) < least_steps) return false;
  }
  return true;
}

void LightSplit::plan(const Mask& light, double shortest) {
  const Values values = values_of(light);
  // Less is better. More exactness than kExactness is worth no further picture.
  const auto cost = [](double error, std::size_t pictures) {
    const bool is_exact = error <= kExactness;
    return std::tuple(!is_exact, is_exact ? pictures : 0, error);
  };
  chosen_ = 0;
  error_ = error_of(divisions_[0], values);
  begins_.assign(1, 0);
  for (std::size_t i = 1; i < divisions_.size(); ++i) {
    const double error = error_of(divisions_[i], values);
    if (!list_begins(divisions_[i], values, shortest, attempt_) ||
        cost(error, attempt_.size()) >= cost(error_, begins_.size()))
      continue;
    chosen_ = i;
    error_ = error;
    std::swap(begins_, attempt_);
  }
}

double LightSplit::begin(std::size_t picture) const {
  return static_cast<double>(begins_[picture]) / static_cast<double>(division().greys.size());
}

void LightSplit::sum(const Mask& light, Mask& to) const {
  expects(are_alike(light, to), "two masks have one size");
  Greys sums{};
  for (std::size_t value = 0; value < sums.size(); ++value)
    sums[value] = static_cast<std::uint8_t>(255 * division().given[value] + 0.5);
  replace_values(sums, light, {0, light.height().count()}, to);
}

void LightSplit::draw(std::size_t picture, const Mask& light, const Rows& rows, Mask& to) const {
  expects(picture < pictures(), "the picture is one of the pictures");
  expects(are_alike(light, to), "two masks have one size");
  expects(0 <= rows.first && rows.end <= light.height().count(), "the masks have these rows");
  replace_values(division().greys[begins_[picture]], light, rows, to);
}

const Mask& GivenLight::of(std::size_t layer, const Mask& light) {
  expects(layer < shortest_.size(), "the layer is one of the print's");
  if (given_.width() != light.width() || given_.height() != light.height())
    given_ = Mask(light.width(), light.height());
  split_.plan(light, shortest_[layer]);
  split_.sum(light, given_);
  return given_;
}

}  // namespace contourd
