#include "daemon/ctl/watch/watched_mask.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "daemon/ctl/terminal/text_columns.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

using Json = WatchedMask::Json;

// Minimum room: in less, a mask cannot be recognised.
constexpr std::size_t kFewestColumns = 30, kFewestRows = 6;
constexpr std::size_t kMostColumns = 1000, kMostRows = 500;
// The mask is not redrawn for up to this many additional rows, because the length of the text above changes
// often.
constexpr std::size_t kSameRows = 3;
// Limits that are larger than the mask of any display.
constexpr std::size_t kMostBytes = 64u << 20;
constexpr std::int32_t kLargestSide = 16'384;

// True for states in which the layer's mask is on the display, or was until now.
bool shows_layer(std::string_view state) {
  constexpr std::array<std::string_view, 5> kStates{"showing", "igniting", "exposing", "rising", "darkening"};
  return std::ranges::find(kStates, state) != kStates.end();
}

std::string caption_of(const Json& reply) {
  const Json& layer = reply.at("layer");
  if (!layer.is_number()) return printable(reply.value("name", ""));
  return fmt::format("layer {}, cut at {:.3f} mm", layer.get<std::int64_t>(),
                     reply.at("cut_at_mm").get<double>());
}

std::int32_t side_in(const Json& reply, const char* name) {
  const auto side = reply.at(name).get<std::int64_t>();
  if (side < 1 || side > kLargestSide) throw std::runtime_error("the picture's size is out of range");
  return static_cast<std::int32_t>(side);
}

std::vector<std::string> split_lines(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t end = 0; (end = text.find('\n')) != std::string_view::npos; text.remove_prefix(end + 1))
    lines.emplace_back(text.substr(0, end));
  return lines;
}

}  // namespace

void WatchedMask::note(const Json& status) {
  const Json job = status.value("job", Json()), manual = status.value("manual", Json());
  if (job.is_object()) {
    if (job.contains("layer") && shows_layer(status.value("state", "")))
      on_screen_ = fmt::format("{} {}", job["layer"].dump(), job.value("name", ""));
    return;
  }
  const Json picture = manual.is_object() ? manual.value("picture", Json()) : Json();
  on_screen_ = picture.is_string() ? "by hand " + picture.get<std::string>() : "";
  if (!on_screen_.empty()) return;
  asked_for_.clear();
  mask_ = Mask();
  drawn_.clear();
}

std::optional<Json> WatchedMask::question(Time now) {
  if (waits_) return std::nullopt;
  if (arriving_) {
    waits_ = true;
    return Json{{"picture", arriving_->number}, {"from", arriving_->png.size()}};
  }
  if (!has_room_ || on_screen_.empty() || on_screen_ == asked_for_ || now < next_) return std::nullopt;
  asked_for_ = on_screen_;
  next_ = now + kInterval;
  waits_ = true;
  return Json::object();
}

// Drops a damaged picture without a message: the next layer's picture may be good.
void WatchedMask::take(const Json& message) {
  if (message.value("id", 0) != kQuestion) return;
  waits_ = false;
  try {
    return take_piece(message.at("result"));
  } catch (const std::exception&) {
    arriving_.reset();
  }
}

void WatchedMask::take_piece(const Json& reply) {
  if (!arriving_) {
    arriving_ = Picture{reply.at("picture").get<std::uint64_t>(),
                        reply.at("bytes").get<std::size_t>(),
                        side_in(reply, "width"),
                        side_in(reply, "height"),
                        caption_of(reply),
                        {}};
    if (arriving_->bytes > kMostBytes) throw std::runtime_error("the picture is too large");
  }
  const auto piece = from_base64(reply.at("data").get_ref<const std::string&>());
  if (!piece || piece->empty()) throw std::runtime_error("a piece is empty or damaged");
  std::vector<std::uint8_t>& png = arriving_->png;
  png.insert(png.end(), piece->begin(), piece->end());
  if (png.size() < arriving_->bytes) return;
  mask_ = decode_png(png, Pixels{arriving_->width}, Pixels{arriving_->height});
  caption_ = arriving_->caption;
  arriving_.reset();
  drawn_.clear();
}

void WatchedMask::connection_lost() {
  waits_ = false;
  arriving_.reset();
  asked_for_.clear();
}

ScreenSize WatchedMask::room_for_text(ScreenSize screen) const {
  const std::size_t rows = screen.rows / 3;
  // A blank line is above the mask.
  const bool can_be_seen = screen.columns >= kFewestColumns && rows > kFewestRows;
  return on_screen_.empty() || !can_be_seen ? screen : ScreenSize{screen.columns, screen.rows - rows};
}

const std::vector<ScreenLine>& WatchedMask::lines(ScreenSize room) {
  room = {std::min(room.columns, kMostColumns), std::min(room.rows, kMostRows)};
  has_room_ = room.columns >= kFewestColumns && room.rows >= kFewestRows;
  static const std::vector<ScreenLine> kNone;
  if (!has_room_ || mask_.pixels().empty()) return kNone;
  const bool fits = !drawn_.empty() && room.columns == drawn_for_.columns && room.rows >= drawn_for_.rows &&
                    room.rows - drawn_for_.rows <= kSameRows;
  if (!fits) draw(room);
  return drawn_;
}

void WatchedMask::draw(ScreenSize room) {
  drawn_for_ = room;
  const bool lit = mask_.lit_pixels() != 0;
  drawn_ = {{cut_to_columns("mask      " + caption_ + (lit ? "" : ": nothing is lit"), room.columns)}};
  if (!lit) return;
  PictureTerminal terminal;
  terminal.ink = ink_;
  terminal.columns = static_cast<int>(room.columns);
  terminal.rows = static_cast<int>(room.rows - 1);
  for (std::string& line : split_lines(draw_picture(mask_, area_to_show(mask_, terminal), terminal)))
    drawn_.push_back({std::move(line)});
}

}  // namespace contourd::ctl
