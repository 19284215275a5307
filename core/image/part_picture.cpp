#include "core/image/part_picture.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/image/picture_view.hpp"

namespace contourd {
namespace {

// The eye is 30 degrees above the horizon.
constexpr double kSinRise = 0.5, kCosRise = 0.866025404;

struct EyeVector {
  double across, up, out;  // in the picture, and towards the eye
};

constexpr EyeVector kLightFromEye{
    kLight.x * kCosTurn + kLight.y * kSinTurn,
    -kLight.x* kSinTurn* kSinRise + kLight.y* kCosTurn* kSinRise + kLight.z* kCosRise,
    kLight.x* kSinTurn* kCosRise - kLight.y* kCosTurn* kCosRise + kLight.z* kSinRise};

constexpr double kMargin = 0.03;  // share of the picture, on each side; the box fits inside
constexpr double kFaint = 0.3;
constexpr float kNone = -1;

// A neighbour is on another surface if its depth differs by more than this many of the picture's pixels from
// the continued slope.
constexpr double kSameSurface = 2.5;
// Radius around a pixel over which its surface's slope is measured, in pixels.
constexpr std::int32_t kSlopeReach = 2;

bool seen(float height) {
  return height >= 0;
}

// How much nearer to the eye a surface comes from a pixel to the next one, across and up.
struct Slope {
  double across = 0, up = 0;
};

// The depths of the pixels around a pixel that shows a surface.
class Around {
 public:
  Around(const std::vector<float>& depths, std::int32_t side, std::int32_t row, std::int32_t column)
      : depths_(depths), side_(side), row_(row), column_(column), here_(*at(0, 0)) {}

  // Returns the slope of the least-squares plane through the neighbours on the same surface.
  [[nodiscard]] Slope slope() const {
    const Slope first{gentler(at(1, 0), at(-1, 0)), gentler(at(0, 1), at(0, -1))};
    double aa = 0, ab = 0, bb = 0, ad = 0, bd = 0;
    for (std::int32_t up = -kSlopeReach; up <= kSlopeReach; ++up) {
      for (std::int32_t across = -kSlopeReach; across <= kSlopeReach; ++across) {
        const float* const depth = at(across, up);
        if (depth == nullptr) continue;
        const double nearer = *depth - here_;
        const double expected = first.across * across + first.up * up;
        const double steepness = 1 + std::max(std::fabs(first.across), std::fabs(first.up));
        if (std::fabs(nearer - expected) > kSameSurface * steepness) continue;
        aa += across * across;
        ab += across * up;
        bb += up * up;
        ad += across * nearer;
        bd += up * nearer;
      }
    }
    const double determinant = aa * bb - ab * ab;
    if (determinant < 1) return first;
    return {(ad * bb - bd * ab) / determinant, (bd * aa - ad * ab) / determinant};
  }

 private:
  [[nodiscard]] const float* at(std::int32_t across, std::int32_t up) const {
    const std::int32_t row = row_ - up, column = column_ + across;
    if (row < 0 || row >= side_ || column < 0 || column >= side_) return nullptr;
    const float& depth = depths_[static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) +
                                 static_cast<std::size_t>(column)];
    return std::isnan(depth) ? nullptr : &depth;
  }

  // Returns the smaller of the steps to both sides: the surface continues on that side.
  [[nodiscard]] double gentler(const float* next, const float* before) const {
    if (next == nullptr && before == nullptr) return 0;
    const double on = next != nullptr ? *next - here_ : HUGE_VAL;
    const double back = before != nullptr ? here_ - *before : HUGE_VAL;
    return std::fabs(on) <= std::fabs(back) ? on : back;
  }

  const std::vector<float>& depths_;
  std::int32_t side_, row_, column_;
  float here_;
};

std::uint8_t shade(const Slope& slope) {
  const EyeVector normal{-slope.across, -slope.up, 1};
  const double length = std::sqrt(normal.across * normal.across + normal.up * normal.up + 1);
  return shade_of(
      (normal.across * kLightFromEye.across + normal.up * kLightFromEye.up + normal.out * kLightFromEye.out) /
      length);
}

struct Square {
  std::int32_t left = 0, top = 0, side = 0;
};

// Returns the square around all lit pixels, with the margin.
Square square_around(const Mask& picture) {
  const std::int32_t side = picture.width().count();
  std::int32_t left = side, right = 0, top = side, bottom = 0;
  for (std::int32_t row = 0; row < side; ++row) {
    for (std::int32_t column = 0; column < side; ++column) {
      if (picture.row(row)[static_cast<std::size_t>(column)] == 0) continue;
      left = std::min(left, column);
      right = std::max(right, column + 1);
      top = std::min(top, row);
      bottom = std::max(bottom, row + 1);
    }
  }
  if (left >= right) return {0, 0, side};
  const auto margin = static_cast<std::int32_t>(std::ceil(std::max(right - left, bottom - top) * kMargin));
  const std::int32_t wanted = std::min(std::max(right - left, bottom - top) + 2 * margin, side);
  const auto begin = [&](std::int32_t first, std::int32_t end) {
    return std::clamp((first + end - wanted) / 2, 0, side - wanted);
  };
  return {begin(left, right), begin(top, bottom), wanted};
}

Mask cut_out(const Mask& picture, const Square& square) {
  Mask cut(Pixels{square.side}, Pixels{square.side});
  const auto left = static_cast<std::size_t>(square.left), side = static_cast<std::size_t>(square.side);
  for (std::int32_t row = 0; row < square.side; ++row)
    std::ranges::copy(picture.row(square.top + row).subspan(left, side), cut.row(row).begin());
  return cut;
}

}  // namespace

// --- masks

void PartPicture::Bordered::take(const Mask& mask) {
  const auto wide = static_cast<std::size_t>(mask.width().count());
  const auto high = static_cast<std::size_t>(mask.height().count());
  stride = wide + 2;
  columns = static_cast<double>(wide);
  rows = static_cast<double>(high);
  pixels.assign(stride * (high + 2), 0);
  for (std::size_t row = 0; row < high; ++row)
    std::ranges::copy(mask.row(static_cast<std::int32_t>(row)),
                      pixels.begin() + static_cast<std::ptrdiff_t>((row + 1) * stride + 1));
}

double PartPicture::Bordered::grey_at(double x, double y) const {
  // Measured from the middle of the border's first pixel.
  const double right = x + 0.5, down = y + 0.5;
  if (!(right >= 0 && right < columns + 1 && down >= 0 && down < rows + 1)) return 0;
  const auto column = static_cast<std::size_t>(right), row = static_cast<std::size_t>(down);
  const double part_x = right - static_cast<double>(column), part_y = down - static_cast<double>(row);
  const std::uint8_t* const at = pixels.data() + row * stride + column;
  const double upper = at[0] + part_x * (at[1] - at[0]);
  const double lower = at[stride] + part_x * (at[stride + 1] - at[stride]);
  return upper + part_y * (lower - upper);
}

// --- the picture

double PartPicture::scale_of(const Box& box, Pixels side) {
  const double columns = box.columns.count(), rows = box.rows.count();
  const double wide = columns * kCosTurn + rows * kSinTurn;
  const double high = (columns * kSinTurn + rows * kCosTurn) * kSinRise + box.height * kCosRise;
  return side.count() * (1 - 2 * kMargin) / std::max(wide, high);
}

PartPicture::PartPicture(const Box& box, Pixels side) : box_(box), side_(side.count()) {
  expects(box.columns.count() > 0 && box.rows.count() > 0 && box.height > 0, "the box holds something");
  expects(side.count() > 0, "a picture has pixels");
  scale_ = scale_of(box, side);
  middle_up_ = box.height * kCosRise / 2;
  // A line of sight moves by at most a pixel from one mask to the next, so it misses no wall wider than a
  // pixel.
  masks_ = static_cast<std::int32_t>(
      std::clamp(std::ceil(box.height * kCosRise / kSinRise * scale_), 1.0, side_ / kSinRise));
  const double down = box.height / masks_, towards = down * kCosRise / kSinRise;
  along_x_ = -towards * kSinTurn * (box.mirror_x ? -1 : 1);
  along_y_ = towards * kCosTurn * (box.mirror_y ? 1 : -1);
  const auto pixels = static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
  surface_.assign(pixels, kNone);
  inside_.assign(pixels, 0);
}

PartPicture::Sight PartPicture::sight_of(std::int32_t row, double height) const {
  const double per_pixel = 1 / scale_;
  const double up = middle_up_ + (side_ / 2.0 - (row + 0.5)) * per_pixel;
  const double across = (0.5 - side_ / 2.0) * per_pixel;
  const double back = (up - height * kCosRise) / kSinRise;
  // Offsets from the box' middle, to the right and to the back.
  const double x = across * kCosTurn - back * kSinTurn, y = across * kSinTurn + back * kCosTurn;
  const double sign_x = box_.mirror_x ? -1 : 1, sign_y = box_.mirror_y ? 1 : -1;
  return {box_.columns.count() / 2.0 + sign_x * x, box_.rows.count() / 2.0 + sign_y * y,
          sign_x * kCosTurn * per_pixel, sign_y * kSinTurn * per_pixel};
}

void PartPicture::add(const Mask& mask, const Mask* beside) {
  expects(taken_ < masks_, "there are at most masks() of them");
  expects(mask.width() == box_.columns && mask.height() == box_.rows, "the mask is as large as the box");
  std::swap(beneath_, last_);
  last_.take(mask);
  if (beside != nullptr) {
    expects(beside->width() == box_.columns && beside->height() == box_.rows,
            "the mask is as large as the box");
    beside_.take(*beside);
    is_beside_.surface.resize(surface_.size());
  }
  // No line of sight comes from beneath the first mask.
  if (taken_ == 0) beneath_ = last_;
  // The rows in which this mask or the one beneath it can be seen.
  const double middle =
      side_ / 2.0 + scale_ * (middle_up_ - (taken_ + 0.5) * box_.height / masks_ * kCosRise);
  const double half =
      scale_ * kSinRise * (box_.columns.count() * kSinTurn + box_.rows.count() * kCosTurn) / 2 + 2 + scale_;
  const auto first = static_cast<std::int32_t>(std::clamp(std::floor(middle - half), 0.0, side_ * 1.0));
  const auto end = static_cast<std::int32_t>(std::clamp(std::ceil(middle + half), 0.0, side_ * 1.0));
  for (std::int32_t row = first; row < end; ++row)
    look_along(row);
  ++taken_;
}

void PartPicture::look_along(std::int32_t row) {
  const Sight sight = sight_of(row, (taken_ + 0.5) * box_.height / masks_);
  // The columns whose sight meets the box at this mask or at the one beneath it, or a pixel beside it.
  double from = 0, to = side_;
  const auto keep = [&](double start, double step, double size, double along) {
    const double room = 1 + std::fabs(along);
    const double a = (-room - start) / step, b = (size + room - start) / step;
    from = std::max(from, std::floor(std::min(a, b)));
    to = std::min(to, std::ceil(std::max(a, b)));
  };
  keep(sight.x, sight.step_x, last_.columns, along_x_);
  keep(sight.y, sight.step_y, last_.rows, along_y_);
  const auto begin = static_cast<std::size_t>(row) * static_cast<std::size_t>(side_);
  for (auto column = static_cast<std::int32_t>(from); column < static_cast<std::int32_t>(to); ++column) {
    const std::size_t at = begin + static_cast<std::size_t>(column);
    const double x = sight.x + column * sight.step_x, y = sight.y + column * sight.step_y;
    const bool inside = last_.grey_at(x, y) >= kLeastGrey;
    if (inside) {
      surface_[at] = static_cast<float>(taken_) + 0.5F;
      if (!is_beside_.surface.empty()) is_beside_.surface[at] = beside_.grey_at(x, y) >= kLeastGrey ? 1 : 0;
    } else if (inside_[at] != 0) {
      surface_[at] = leaves_at(x, y);
    }
    inside_[at] = inside ? 1 : 0;
  }
}

// Returns the height, in masks, at which the line of sight that reaches (x, y) in the last mask left the part
// after the mask beneath.
float PartPicture::leaves_at(double x, double y) const {
  double in = 0, out = 1;  // shares of the distance from the mask beneath to the last one
  for (int halving = 0; halving < 6; ++halving) {
    const double part = (in + out) / 2, rest = 1 - part;
    const double at_x = x + rest * along_x_, at_y = y + rest * along_y_;
    const double grey = rest * beneath_.grey_at(at_x, at_y) + part * last_.grey_at(at_x, at_y);
    (grey >= kLeastGrey ? in : out) = part;
  }
  return static_cast<float>(taken_ - 0.5 + in);
}

void PartPicture::add_faintly_from_here() {
  present_ = surface_;
  is_beside_.present = is_beside_.surface;
}

std::vector<float> PartPicture::depths_of(const Surface& surface) const {
  std::vector<float> depths(surface.size());
  const auto side = static_cast<std::size_t>(side_);
  for (std::size_t at = 0; at < surface.size(); ++at) {
    const std::size_t row = at / side;
    const double up = middle_up_ * scale_ + side_ / 2.0 - (static_cast<double>(row) + 0.5);
    const double height = static_cast<double>(surface[at]) * box_.height / masks_ * scale_;
    depths[at] = seen(surface[at]) ? static_cast<float>((height - up * kCosRise) / kSinRise) : NAN;
  }
  return depths;
}

Mask PartPicture::shaded(const Surface& surface) const {
  Mask picture(Pixels{side_}, Pixels{side_});
  const std::vector<float> depths = depths_of(surface);
  for (std::int32_t row = 0; row < side_; ++row) {
    const auto pixels = picture.row(row);
    for (std::int32_t column = 0; column < side_; ++column) {
      const auto at = static_cast<std::size_t>(column);
      if (seen(surface[static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + at]))
        pixels[at] = shade(Around(depths, side_, row, column).slope());
    }
  }
  return picture;
}

void PartPicture::mark_beside(Mask& picture) const {
  if (is_beside_.surface.empty()) return;
  for (std::int32_t row = 0; row < side_; ++row) {
    const auto pixels = picture.row(row);
    for (std::size_t column = 0; column < pixels.size(); ++column) {
      const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + column;
      const bool is_present = !is_beside_.present.empty() && seen(present_[at]);
      const std::uint8_t mark = is_present ? is_beside_.present[at] : is_beside_.surface[at];
      pixels[column] = static_cast<std::uint8_t>((pixels[column] & 0xFEU) | mark);
    }
  }
}

PixelPoint PartPicture::project(const Place& place) const {
  const double x = (place.columns - 0.5) * box_.columns.count() * (box_.mirror_x ? -1 : 1);
  const double y = (place.rows - 0.5) * box_.rows.count() * (box_.mirror_y ? 1 : -1);
  const double across = x * kCosTurn + y * kSinTurn, back = y * kCosTurn - x * kSinTurn;
  const double up = place.height * box_.height * kCosRise + back * kSinRise;
  return {side_ / 2.0 + across * scale_, side_ / 2.0 - (up - middle_up_) * scale_};
}

PartPicture::Drawing PartPicture::draw(std::span<const Place> places) const {
  Mask picture = whole_picture();
  mark_beside(picture);
  const Square square = square_around(picture);
  std::vector<PixelPoint> marks;
  for (const Place& place : places) {
    const PixelPoint at = project(place);
    marks.push_back({at.x - square.left, at.y - square.top});
  }
  return {cut_out(picture, square), std::move(marks)};
}

Mask PartPicture::whole_picture() const {
  if (present_.empty()) return shaded(surface_);
  Mask picture = shaded(present_);
  const Mask whole = shaded(surface_);
  for (std::int32_t row = 0; row < side_; ++row) {
    const auto there = picture.row(row);
    const auto faint = whole.row(row);
    for (std::size_t column = 0; column < there.size(); ++column) {
      const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + column;
      if (surface_[at] <= present_[at]) continue;  // not hidden by a faint part
      there[column] = static_cast<std::uint8_t>((1 - kFaint) * there[column] + kFaint * faint[column]);
    }
  }
  return picture;
}

}  // namespace contourd
