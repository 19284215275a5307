#include "daemon/control/screen_control.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>

#include "daemon/control/file_pieces.hpp"

namespace contourd {

using Json = ScreenControl::Json;

ScreenControl::ScreenControl(EventLoop& loop, Worker& worker, const CurrentJob& job,
                             const ManualProcess& manual)
    : job_(job), manual_(manual), copy_(loop, worker, [this] { return subject().shown; }) {}

ControlMethods ScreenControl::methods() {
  return {
      {"mask",
       {.description = "Returns the picture that the display shows or showed last, in pieces of a PNG file.",
        .parameters = {piece_parameter("picture", "the picture, for the next piece"),
                       piece_parameter("from", "position of the piece: the number of bytes received")},
        .call_later = [this](const Json& given, const ControlCaller&, ControlMethod::Later later) {
          return mask(given, std::move(later));
        }}}};
}

// Masks of prints get even numbers and pictures shown by hand odd ones, as both are counted separately.
ScreenControl::Subject ScreenControl::subject() const {
  ShownMask shown = job_.print().shown();
  if (shown.mask != nullptr) {
    shown.number *= 2;
    return {shown, job_.print().shows_mask()};
  }
  shown = manual_.shown();
  shown.number = shown.number * 2 + 1;
  return {shown, shown.mask != nullptr};
}

Json ScreenControl::reply(const ScreenCopy::Picture& picture, std::size_t from) const {
  const Subject now = subject();
  const bool is_current = now.shown.mask != nullptr && now.shown.number == picture.number;
  Json reply{{"picture", picture.number},
             {"name", picture.name},
             {"layer", picture.layer ? Json(*picture.layer + 1) : Json()},
             {"cut_at_mm", picture.layer ? Json(to_millimeters(picture.cut_at).count()) : Json()},
             {"on_screen", is_current && now.on_screen},
             {"width", picture.width.count()},
             {"height", picture.height.count()}};
  add_piece(reply, picture.png, from);
  return reply;
}

void ScreenControl::mask(const Json& given, ControlMethod::Later later) {
  const auto wanted = given.value("picture", std::uint64_t{0}), from = given.value("from", std::uint64_t{0});
  if (wanted != 0) {
    const std::shared_ptr<const ScreenCopy::Picture> picture = copy_.picture(wanted);
    if (!picture) throw ControlRefusal(fmt::format("picture {} is no longer kept", wanted));
    if (from >= picture->png.size())
      throw InvalidParameters(
          fmt::format("from must be below {}, the size of picture {} in bytes", picture->png.size(), wanted));
    return later(reply(*picture, from));
  }
  if (from != 0) throw InvalidParameters("from needs picture");
  const Subject now = subject();
  if (now.shown.mask == nullptr) throw ControlRefusal("nothing is shown: the screen is black");
  if (const auto picture = copy_.picture(now.shown.number)) return later(reply(*picture, 0));
  copy_.take([this, later = std::move(later)](const std::shared_ptr<const ScreenCopy::Picture>& picture,
                                              const std::string& trouble) {
    if (picture)
      later(reply(*picture, 0));
    else
      later(ControlRefusal(trouble));
  });
}

}  // namespace contourd
