#include "daemon/ctl/watch/watched_mask.hpp"

#include "daemon/system/base64.hpp"
#include "hw/png_file.hpp"
#include "tests/catch.hpp"

using namespace contourd::ctl;
using Json = WatchedMask::Json;

namespace {

constexpr ScreenSize kRoom{80, 20};
constexpr std::size_t kPieceBytes = 40;

Mask lit_square() {
  Mask mask(Pixels{192}, Pixels{108});
  for (std::int32_t y = 40; y < 60; ++y)
    std::ranges::fill(mask.row(y).subspan(80, 20), std::uint8_t{255});
  return mask;
}

Json status_of_layer(int layer, const std::string& state = "exposing") {
  return {
      {"state", state}, {"job", {{"name", "gear"}, {"layer", layer}}}, {"manual", {{"picture", nullptr}}}};
}
Json status_without_job(const Json& picture = nullptr) {
  return {{"state", "idle"}, {"job", nullptr}, {"manual", {{"picture", picture}}}};
}

// Returns contourd's answer to the method `mask`.
Json answer(const Json& question, int layer, const Mask& mask = lit_square()) {
  const std::vector<std::uint8_t> png = encode_png(mask);
  const auto from = question.value("from", std::size_t{0});
  const auto piece = std::span(png).subspan(from, std::min(kPieceBytes, png.size() - from));
  return {{"id", WatchedMask::kQuestion},
          {"result",
           {{"picture", 2 * layer},
            {"name", "gear"},
            {"layer", layer > 0 ? Json(layer) : Json()},
            {"cut_at_mm", layer > 0 ? Json(0.05 * layer) : Json()},
            {"width", mask.width().count()},
            {"height", mask.height().count()},
            {"bytes", png.size()},
            {"data", base64(piece)}}}};
}

// Fetches all pieces of a mask. Returns their number.
int fetch(WatchedMask& mask, WatchedMask::Time now, int layer) {
  int questions = 0;
  while (const std::optional<Json> question = mask.question(now)) {
    ++questions;
    CHECK_FALSE(mask.question(now));  // one at a time
    mask.take(answer(*question, layer));
  }
  return questions;
}

const WatchedMask::Time kStart{1h};

}  // namespace

TEST_CASE("A watched mask is requested piece by piece, once per layer, and drawn with its layer") {
  WatchedMask mask(PictureInk::Characters);
  CHECK(mask.lines(kRoom).empty());
  mask.note(status_of_layer(3));
  CHECK(fetch(mask, kStart, 3) > 1);
  const std::vector<ScreenLine> lines = mask.lines(kRoom);
  REQUIRE(lines.size() > 5);
  CHECK(lines.size() <= kRoom.rows);
  CHECK(lines.front().text == "mask      layer 3, cut at 0.150 mm");
  CHECK(std::ranges::any_of(
      lines, [](const ScreenLine& line) { return line.text.find("\u2588") != std::string::npos; }));
  mask.note(status_of_layer(3));
  CHECK(fetch(mask, kStart + 10s, 3) == 0);
  mask.note(status_of_layer(4, "lowering"));  // the display still shows layer 3
  CHECK(fetch(mask, kStart + 10s, 4) == 0);
  mask.note(status_of_layer(4, "showing"));
  CHECK(fetch(mask, kStart + 10s, 4) > 0);
  CHECK(mask.lines(kRoom).front().text == "mask      layer 4, cut at 0.200 mm");
}

TEST_CASE("No mask is requested if there is no room for it, or too soon after the previous one") {
  WatchedMask mask(PictureInk::Characters);
  mask.note(status_of_layer(1));
  for (const ScreenSize small : {ScreenSize{80, 5}, ScreenSize{29, 20}, ScreenSize{0, 0}}) {
    CHECK(mask.lines(small).empty());
    CHECK_FALSE(mask.question(kStart));
  }
  (void)mask.lines(kRoom);
  CHECK(fetch(mask, kStart, 1) > 0);
  mask.note(status_of_layer(2));
  CHECK(fetch(mask, kStart + WatchedMask::kInterval - 1ms, 2) == 0);
  CHECK(fetch(mask, kStart + WatchedMask::kInterval, 2) > 0);
}

TEST_CASE("A third of the rows is for a mask, if there is one and it can be recognised there") {
  WatchedMask mask(PictureInk::Characters);
  CHECK(mask.room_for_text({80, 24}).rows == 24);
  mask.note(status_of_layer(1));
  const ScreenSize text = mask.room_for_text({80, 24});
  CHECK((text.columns == 80 && text.rows == 16));
  CHECK(mask.room_for_text({80, 60}).rows == 40);
  CHECK(mask.room_for_text({80, 20}).rows == 20);
  CHECK(mask.room_for_text({29, 24}).rows == 24);
  CHECK(mask.room_for_text({1, 1}).rows == 1);
  (void)mask.lines({80, 24 - text.rows - 1});
  CHECK(fetch(mask, kStart, 1) > 0);
  mask.note(status_without_job());
  CHECK(mask.room_for_text({80, 24}).rows == 24);
}

TEST_CASE("A picture of manual control is watched until it ends") {
  WatchedMask mask(PictureInk::Characters);
  (void)mask.lines(kRoom);
  mask.note(status_without_job("grid"));
  CHECK(fetch(mask, kStart, 0) > 0);
  CHECK(mask.lines(kRoom).front().text == "mask      gear");
  mask.note(status_without_job());
  CHECK(mask.lines(kRoom).empty());
  CHECK_FALSE(mask.question(kStart + 1min));
  mask.note(status_without_job("grid"));
  CHECK(mask.question(kStart + 1min));
}

TEST_CASE("A damaged answer loses the mask of its layer only") {
  const Json good = answer(Json::object(), 1);
  std::vector<Json> wrong{{{"id", WatchedMask::kQuestion}, {"error", {{"message", "nothing is shown"}}}},
                          {{"id", WatchedMask::kQuestion}, {"result", nullptr}}};
  for (const auto& [key, value] :
       {std::pair("data", Json("")), std::pair("data", Json("?")), std::pair("width", Json(0)),
        std::pair("height", Json(1'000'000)), std::pair("bytes", Json(std::size_t{1} << 40)),
        std::pair("bytes", Json(kPieceBytes)), std::pair("layer", Json()), std::pair("picture", Json("x"))}) {
    wrong.push_back(good);
    wrong.back()["result"][key] = value;
  }
  wrong.back()["result"].erase("data");
  for (const Json& message : wrong) {
    CAPTURE(message.dump());
    WatchedMask mask(PictureInk::Characters);
    (void)mask.lines(kRoom);
    mask.note(status_of_layer(1));
    REQUIRE(mask.question(kStart));
    mask.take(message);
    mask.connection_lost();
    CHECK(mask.lines(kRoom).empty());
    mask.note(status_of_layer(2));
    CHECK(fetch(mask, kStart + 1min, 2) > 0);
    CHECK_FALSE(mask.lines(kRoom).empty());
  }
}

TEST_CASE("A dark mask is reported as such, and a small change of the room does not redraw a mask") {
  WatchedMask mask(PictureInk::Characters);
  (void)mask.lines(kRoom);
  mask.note(status_of_layer(1));
  const std::optional<Json> question = mask.question(kStart);
  REQUIRE(question);
  const Mask dark(Pixels{16}, Pixels{9});
  for (std::optional<Json> next = question; next; next = mask.question(kStart))
    mask.take(answer(*next, 1, dark));
  REQUIRE(mask.lines(kRoom).size() == 1);
  CHECK(mask.lines(kRoom).front().text == "mask      layer 1, cut at 0.050 mm: nothing is lit");
  mask.note(status_of_layer(2));
  CHECK(fetch(mask, kStart + 1min, 2) > 0);
  const std::size_t rows = mask.lines(kRoom).size();
  CHECK(mask.lines({kRoom.columns, kRoom.rows + 3}).size() == rows);
  CHECK(mask.lines({kRoom.columns, kRoom.rows + 30}).size() > rows);
  CHECK(mask.lines({kRoom.columns, kRoom.rows - 5}).size() <= kRoom.rows - 5);
}
