#include "core/overhangs/layer_parts.hpp"

#include "tests/catch.hpp"
#include "tests/core/text_mask.hpp"

TEST_CASE("Pixels that touch by a side or a corner are one part") {
  const MaskRuns dark = runs_of({"......", "......", "......"});
  const MaskRuns lit = runs_of({"#.#..#", ".#....", "....##"});
  LayerParts parts;
  parts.add_layer(lit, dark);
  REQUIRE(parts.parts().size() == 3);
  CHECK(parts.parts()[0].pixels == 3);
  CHECK(parts.parts()[1].pixels == 1);
  CHECK(parts.parts()[2].pixels == 2);
  CHECK(parts.bodies() == 3);
}

TEST_CASE("Two groups of ten pixels that touch only by a corner are two parts, nine and ten are one") {
  const MaskRuns dark = runs_of({"..........", "..........", "..........", ".........."});
  const MaskRuns ten = runs_of({"#####.....", "#####.....", ".....#####", ".....#####"});
  LayerParts parts;
  parts.add_layer(ten, dark);
  REQUIRE(parts.parts().size() == 2);
  CHECK(parts.parts()[0].pixels == 10);
  CHECK(parts.part_of_run()[2] == 1);
  const MaskRuns nine = runs_of({".####.....", "#####.....", ".....#####", ".....#####"});
  LayerParts one;
  one.add_layer(nine, dark);
  REQUIRE(one.parts().size() == 1);
  CHECK(one.parts()[0].pixels == 19);
}

TEST_CASE("A part continues the body under it, and begins a new one where there is none") {
  const MaskRuns dark = runs_of({"......"}), first = runs_of({"##...."}), second = runs_of({".##..#"});
  LayerParts parts;
  parts.add_layer(first, dark);
  const std::uint32_t body = parts.parts()[0].body;
  parts.add_layer(second, first);
  REQUIRE(parts.parts().size() == 2);
  CHECK(parts.parts()[0] == LayerPart{body, 2, 1, 3, 0});
  CHECK(parts.parts()[1].carried == 0);
  CHECK(parts.parts()[1].body != body);
  CHECK(parts.meetings().empty());
}

TEST_CASE("Bodies that meet are one from then on, and their meeting is reported once") {
  const MaskRuns dark = runs_of({"......", "......"}), apart = runs_of({"##..##", "......"});
  const MaskRuns together = runs_of({"######", "......"});
  LayerParts parts;
  parts.add_layer(apart, dark);
  const std::uint32_t left = parts.parts()[0].body, right = parts.parts()[1].body;
  parts.add_layer(together, apart);
  REQUIRE(parts.meetings().size() == 1);
  CHECK(parts.meetings()[0].into == left);
  CHECK(parts.meetings()[0].body == right);
  parts.add_layer(apart, together);
  CHECK(parts.parts()[0].body == left);
  CHECK(parts.parts()[1].body == left);
  CHECK(parts.meetings().empty());
}
