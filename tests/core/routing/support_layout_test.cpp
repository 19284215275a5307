#include "core/routing/support_layout.hpp"

#include <variant>

#include "tests/catch.hpp"
#include "tests/core/routing/supports_fixture.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

using models::together;

namespace {

constexpr Direction kDown{0, 0, -1};

SupportContact contact(double x, double y, double z, Direction outward = kDown) {
  return {{x, y, z}, outward, ContactCause::Overhang, 8};
}

Supports supports_for(const models::Facets& facets, std::vector<SupportContact> contacts,
                      const SupportSettings& settings = {}) {
  LitLayers layers;
  testing::stack({facets}, kBuildArea, layers);
  return *lay_out_supports(std::move(contacts), layers, kBuildArea, settings);
}

// Checks that hold for all supports. A pixel of a sweep hides up to a tenth of a micrometre of a flat
// surface, and a path is sampled every 0.2 mm, which hides up to 5 micrometres.
constexpr double kLooks_mm = 0.005;

void check_all(const Supports& supports, const models::Facets& facets, const SupportSettings& settings = {}) {
  REQUIRE(supports.structure);
  CHECK(testing::least_clearance(supports, facets, settings) >= settings.clearance.count() - kLooks_mm);
  CHECK(testing::is_within(supports, kBuildArea));
  CHECK(testing::is_steep(supports));
  CHECK(testing::is_connected(supports, facets));
}

// Returns a table with four legs of 2 mm and a top of 16 by 12 mm from 12 to 14 mm above the plate.
models::Facets table() {
  models::Facets all = models::box({-8, -6, 12}, {8, 6, 14});
  for (const float x : {-8.0F, 6.0F}) {
    for (const float y : {-6.0F, 4.0F})
      all = together(std::move(all), models::box({x, y, 0}, {x + 2, y + 2, 12}));
  }
  return all;
}

std::vector<SupportContact> under_table() {
  std::vector<SupportContact> contacts;
  for (const double x : {-4.0, 0.0, 4.0}) {
    for (const double y : {-3.0, 0.0, 3.0})
      contacts.push_back(contact(x, y, 12));
  }
  return contacts;
}

}  // namespace

TEST_CASE("A model that needs no supports gets none") {
  const Supports supports = supports_for(table(), {});
  CHECK_FALSE(supports.structure);
  CHECK(supports.contacts.empty());
  CHECK(supports.unheld.empty());
  CHECK(supports.volume_mm3 == 0);
}

TEST_CASE("Tips with a depth of at most a nanometre do not reach into the model") {
  const auto primitives = [](double depth_mm) {
    SupportSettings settings;
    settings.tip_depth = Millimeters{depth_mm};
    const Supports supports = supports_for(table(), under_table(), settings);
    check_all(supports, table(), settings);
    return supports.structure->primitives().size();
  };
  const std::size_t none = primitives(0);
  CHECK(primitives(0.2) == none + under_table().size());
  for (const double depth_mm : {1e-7, 1e-12, 1e-100, 1e-170, 5e-324})
    CHECK(primitives(depth_mm) == none);
}

TEST_CASE("A ball above the plate stands on branches that meet") {
  models::Facets ball = models::globe(6, 24, 48);
  models::translate(ball, 0, 0, 11);
  std::vector<SupportContact> contacts{contact(0, 0, 5)};
  for (int i = 0; i < 8; ++i) {
    const double angle = i * 0.785398, s = 0.5, c = std::sqrt(1 - s * s);
    const Direction outward{s * std::cos(angle), s * std::sin(angle), -c};
    contacts.push_back(contact(6 * outward.x, 6 * outward.y, 11 + 6 * outward.z, outward));
  }
  const Supports supports = supports_for(ball, contacts);
  CHECK(supports.contacts.size() == 9);
  CHECK(supports.unheld.empty());
  CHECK(supports.feet_on_models == 0);
  CHECK(supports.feet < 6);
  check_all(supports, ball);
}

TEST_CASE("A table's top is held between its legs by fewer feet than contacts") {
  const Supports supports = supports_for(table(), under_table());
  CHECK(supports.contacts.size() == 9);
  CHECK(supports.feet <= 3);
  check_all(supports, table());
}

TEST_CASE("Branches that meet take less resin than pillars that do not") {
  double alone = 0;
  for (const SupportContact& each : under_table())
    alone += supports_for(table(), {each}).volume_mm3;
  CHECK(supports_for(table(), under_table()).volume_mm3 < 0.6 * alone);
}

TEST_CASE("The wall of a tilted plate is held along its normal, no flatter than 45 degrees") {
  // The underside rises at 30 degrees from the vertical.
  models::Facets plate = models::box({-1, -6, 0}, {1, 6, 16});
  for (Facet& facet : plate) {
    for (Vertex& v : facet.vertices)
      v.x += v.z * 0.577F;
  }
  const Direction outward{0.866, 0, -0.5};
  const auto on_wall = [](double y, double z) { return PlatePoint{1 + z * 0.577, y, z}; };
  std::vector<SupportContact> contacts;
  for (const double y : {-4.0, 0.0, 4.0})
    contacts.push_back({on_wall(y, 12), outward, ContactCause::Overhang, 8});
  const Supports supports = supports_for(plate, contacts);
  CHECK(supports.contacts.size() == 3);
  check_all(supports, plate);
}

TEST_CASE("An arch over a block has a foot on the block if no path leads to the plate") {
  // A tunnel with a floor, 12 mm long and 8 mm high, closed on all sides.
  const models::Facets room =
      together(models::box({-8, -8, 0}, {8, 8, 20}), models::inverted(models::box({-5, -5, 6}, {5, 5, 14})));
  const Supports supports = supports_for(room, {contact(0, 0, 14), contact(2, 1, 14)});
  CHECK(supports.contacts.size() == 2);
  CHECK(supports.feet == 0);
  CHECK(supports.feet_on_models >= 1);
  CHECK(testing::is_connected(supports, room));
  CHECK(testing::least_clearance(supports, room, {}) >= 0.5 - kLooks_mm);
}

TEST_CASE("A support that holds a hair of one pixel is listed") {
  // Pixels of 0.1 mm.
  for (const float width : {0.1F, 0.2F, 0.4F}) {
    INFO("hair of " << width << " mm");
    const models::Facets hair =
        together(models::box({-5, -5, 14}, {5, 5, 16}), models::box({0, 0, 10}, {width, width, 14}));
    SupportContact place = contact(width / 2, width / 2, 10);
    place.cause = ContactCause::Island;
    const Supports supports = supports_for(hair, {place, contact(-4, -4, 14)});
    REQUIRE(supports.contacts.size() == 2);
    CHECK(supports.on_hairs.size() == (width < 0.15F ? 1 : 0));
  }
  // A cone that points down is thick enough at the end of the tip.
  models::Facets cone = models::cone(4, 6, 48);
  orient(cone, {.x_deg = 180});
  models::translate(cone, 0, 0, 14);
  CHECK(supports_for(cone, {contact(0, 0, 8)}).on_hairs.empty());
}

TEST_CASE("Supports in a sealed hollow are listed, and a dome in one gets none") {
  const auto block_around = [](models::Facets hollow) {
    return together(models::box({-12, -12, 0}, {12, 12, 24}), models::inverted(std::move(hollow)));
  };
  const Supports under_ceiling = supports_for(block_around(models::box({-5, -5, 6}, {5, 5, 14})),
                                              {contact(0, 0, 14), contact(0, 0, 24)});
  REQUIRE(under_ceiling.in_hollows.size() == 1);
  CHECK(under_ceiling.in_hollows[0].place.z == 14);
  models::Facets dome = models::globe(8, 80, 160);
  models::translate(dome, 0, 0, 12);
  const Supports under_dome = supports_for(block_around(dome), {contact(0.5, 0, 19.97)});
  CHECK(under_dome.contacts.empty());
  CHECK(under_dome.unheld.empty());
  // An open box over the plate.
  const Supports open =
      supports_for(together(models::box({-8, -8, 0}, {8, -6, 20}), models::box({-8, -8, 14}, {8, 8, 20})),
                   {contact(0, 0, 14)});
  CHECK(open.contacts.size() == 1);
  CHECK(open.in_hollows.empty());
}

TEST_CASE(
    "A support fills a gap narrower than itself only where nothing else bears the part, and is listed") {
  for (const float gap_mm : {0.35F, 0.5F, 0.9F}) {
    INFO("gap of " << gap_mm << " mm");
    const models::Facets hinge =
        together(models::box({-8, -8, 0}, {8, 8, 5}), models::box({-6, -6, 5 + gap_mm}, {6, 6, 9}));
    SupportContact place = contact(0, 0, 5 + double{gap_mm});
    const Supports overhang = supports_for(hinge, {place});
    CHECK(overhang.contacts.empty());
    CHECK(overhang.unheld.empty());
    CHECK(overhang.over_gaps == std::vector<SupportContact>{place});
    for (const ContactCause cause : {ContactCause::Island, ContactCause::Peel}) {
      place.cause = cause;
      const Supports supports = supports_for(hinge, {place});
      CHECK(supports.contacts.size() == 1);
      CHECK(supports.in_gaps == supports.contacts);
    }
  }
  const models::Facets wide =
      together(models::box({-8, -8, 0}, {8, 8, 5}), models::box({-6, -6, 6.4F}, {6, 6, 9}));
  const Supports supports = supports_for(wide, {contact(0, 0, 6.4)});
  CHECK(supports.contacts.size() == 1);
  CHECK(supports.in_gaps.empty());
}

TEST_CASE("No foot stands on the model if a path leads to the plate") {
  // A bridge over a narrow block: the path goes around the block.
  const models::Facets bridge =
      together(together(models::box({-12, -4, 0}, {-10, 4, 22}), models::box({10, -4, 0}, {12, 4, 22})),
               together(models::box({-12, -4, 20}, {12, 4, 22}), models::box({-2, -2, 0}, {2, 2, 6})));
  const Supports supports = supports_for(bridge, {contact(0, 0, 20)});
  CHECK(supports.feet == 1);
  CHECK(supports.feet_on_models == 0);
  check_all(supports, bridge);
}

TEST_CASE("A comb's slots are held, its teeth not touched") {
  models::Facets comb = models::box({-12, -3, 15}, {12, 3, 17});
  for (int i = 0; i < 5; ++i) {
    const float x = -12.0F + static_cast<float>(i) * 5.5F;
    comb = together(std::move(comb), models::box({x, -3, 0}, {x + 2, 3, 15}));
  }
  std::vector<SupportContact> contacts;
  for (int i = 0; i < 4; ++i) {
    for (const double y : {-2.0, 2.0})
      contacts.push_back(contact(-12 + i * 5.5 + 3.75, y, 15));
  }
  const Supports supports = supports_for(comb, contacts);
  CHECK(supports.contacts.size() == 8);
  check_all(supports, comb);
}

TEST_CASE("Branches under a ring stay clear of the pin in its middle, which is another model") {
  const models::Facets ring = together(models::box({-6, -6, 10}, {6, 6, 13}),
                                       models::inverted(models::box({-3, -3, 10}, {3, 3, 13})));
  const models::Facets pin = models::box({-1.5F, -1.5F, 0}, {1.5F, 1.5F, 18});
  LitLayers layers;
  testing::stack({ring, pin}, kBuildArea, layers);
  std::vector<SupportContact> contacts;
  for (const double a : {-4.5, 4.5}) {
    for (const double b : {-4.5, 0.0, 4.5}) {
      contacts.push_back(contact(a, b, 10));
      if (b == 0) contacts.push_back(contact(b, a, 10));
    }
  }
  const Supports supports = *lay_out_supports(contacts, layers, kBuildArea, {});
  CHECK(supports.contacts.size() == 8);
  check_all(supports, together(ring, pin));
}

TEST_CASE("Supports at the build area's edge stay inside it") {
  const models::Facets box = models::box({14, 9, 8}, {20, 15, 12});
  const Supports supports =
      supports_for(box, {contact(19.7, 14.7, 8), contact(19.7, 9.5, 8), contact(14.3, 14.7, 8)});
  CHECK(supports.contacts.size() == 3);
  check_all(supports, box);
}

TEST_CASE("A place that no support reaches is reported with its reason") {
  // A slot of 0.5 mm between two walls has no room for a support.
  const models::Facets walls =
      together(models::box({-6, -8, 0}, {-0.25F, 8, 20}), models::box({0.25F, -8, 0}, {6, 8, 20}));
  const Supports supports =
      supports_for(together(walls, models::box({-0.25F, -5, 12}, {0.25F, 5, 14})), {contact(0, 0, 12)});
  CHECK_FALSE(supports.structure);
  REQUIRE(supports.unheld.size() == 1);
  CHECK(supports.unheld[0].contact == contact(0, 0, 12));
  CHECK(supports.unheld[0].why == "no path leads to the plate or to a place on the model");
}

TEST_CASE("A place that no tip reaches is held beside it, where the material is connected") {
  // A slot too narrow for a tip, from the middle of a bar's underside to the plate.
  models::Facets bar = models::box({-6, -1, 10}, {6, 1, 12});
  for (const float x : {-0.3F, 0.2F})
    bar = together(std::move(bar), models::box({x, -0.8F, 9.4F}, {x + 0.1F, 0.8F, 10}));
  const Supports supports = supports_for(bar, {contact(0, 0, 10)});
  CHECK(supports.unheld.empty());
  REQUIRE(supports.contacts.size() == 1);
  const PlatePoint held = supports.contacts[0].place;
  CHECK(std::hypot(held.x, held.y) <= 0.91);
  CHECK(std::fabs(held.x) >= 0.3 - 1e-9);
  CHECK(std::fabs(held.z - 10) < 1e-9);
  // A neighbouring part that is not connected does not hold the place.
  const models::Facets walls =
      together(models::box({-2, -6, 0}, {-0.25F, 6, 20}), models::box({0.25F, -6, 0}, {2, 6, 20}));
  const models::Facets apart = together(walls, models::box({-0.15F, -2, 10}, {0.15F, 2, 12}));
  CHECK(supports_for(apart, {contact(0, 0, 10)}).contacts.empty());
}

TEST_CASE("An island close beside a wall, with room for no tip, is joined to the wall") {
  // A space as narrow as a tip, with a flake beside one of its walls.
  const models::Facets room = together(models::box({-8, -8, 0}, {8, 8, 20}),
                                       models::inverted(models::box({-0.25F, -5, 6}, {0.25F, 5, 18})));
  const models::Facets all = together(room, models::box({-0.1F, -0.1F, 12}, {0.1F, 0.1F, 13}));
  SupportContact flake = contact(0, 0, 12);
  CHECK(supports_for(all, {flake}).contacts.empty());
  flake.cause = ContactCause::Island;
  const Supports supports = supports_for(all, {flake});
  CHECK(supports.unheld.empty());
  REQUIRE(supports.structure);
  // The strut leads from the flake into the wall at 45 degrees.
  const bool leads_into_wall =
      std::ranges::any_of(supports.structure->primitives(), [](const SupportPrimitive& each) {
        const auto* strut = std::get_if<Frustum>(&each);
        return strut != nullptr && strut->upper == PlatePoint{0, 0, 12} && std::fabs(strut->lower.x) > 0.25 &&
               std::fabs(strut->lower.x) <= 12 - strut->lower.z + 1e-9;
      });
  CHECK(leads_into_wall);
}

TEST_CASE("An island close above other material stands on it, instead of being held higher and beside it") {
  // A pin under a bar whose underside is a layer higher, and a post 0.2 mm beneath the pin.
  const models::Facets bar = together(models::box({-0.1F, -0.1F, 10.2F}, {0.1F, 0.1F, 10.4F}),
                                      models::box({-6, -2, 10.25F}, {6, 2, 12}));
  const models::Facets post = models::box({-0.1F, -0.1F, 0}, {0.1F, 0.1F, 10});
  SupportContact pin = contact(0, 0, 10.2);
  pin.cause = ContactCause::Island;
  const Supports on_post = supports_for(together(post, bar), {pin});
  REQUIRE(on_post.contacts.size() == 1);
  CHECK(on_post.contacts[0].place == pin.place);
  // In a slot without a floor, holding the island one layer higher is better than not at all.
  models::Facets slot = bar;
  for (const float x : {-0.3F, 0.2F})
    slot = together(std::move(slot), models::box({x, -1.8F, 9.4F}, {x + 0.1F, 1.8F, 10.25F}));
  const Supports beside = supports_for(slot, {pin});
  REQUIRE(beside.contacts.size() == 1);
  CHECK(std::fabs(beside.contacts[0].place.z - 10.25) < 1e-9);
}

TEST_CASE("Tips and feet reach no deeper into a sheet than it is thick") {
  // All of the build area lies under the lower sheet.
  const models::Facets sheets =
      together(models::box({-20, -15, 5}, {20, 15, 5.1F}), models::box({-2, -2, 9}, {2, 2, 9.1F}));
  const Supports supports = supports_for(sheets, {contact(0, 0, 9)});
  REQUIRE(supports.structure);
  double lowest = 9, highest = 5;
  for (const SupportPrimitive& each : supports.structure->primitives()) {
    if (const auto* frustum = std::get_if<Frustum>(&each)) {
      lowest = std::min(lowest, frustum->lower.z);
      highest = std::max(highest, frustum->upper.z);
    }
  }
  CHECK(std::fabs(lowest - 5) < 1e-6);
  CHECK(std::fabs(highest - 9.1) < 1e-6);
}

TEST_CASE("The lowest of a million places are held, and the others are reported") {
  std::vector<SupportContact> contacts;
  for (int i = 0; i < 70; ++i) {
    for (int k = 0; k < 70; ++k)
      contacts.push_back(contact(-7 + i * 0.2, -5 + k * 0.14, 12));
  }
  const Supports supports = supports_for(table(), contacts);
  CHECK(supports.contacts.size() + supports.unheld.size() == contacts.size());
  CHECK(supports.contacts.size() <= kMostContacts);
  CHECK(supports.unheld.back().why ==
        "the limit of 4096 contacts is reached below it, and nothing above it is held either");
}

TEST_CASE("The same places give the same supports in any order") {
  std::vector<SupportContact> contacts = under_table();
  const Supports one = supports_for(table(), contacts);
  std::ranges::reverse(contacts);
  const Supports other = supports_for(table(), contacts);
  CHECK(std::ranges::equal(one.structure->primitives(), other.structure->primitives()));
  CHECK(one.contacts == other.contacts);
}

TEST_CASE("A stopped layout returns nothing") {
  LitLayers layers;
  testing::stack({table()}, kBuildArea, layers);
  std::stop_source source;
  source.request_stop();
  CHECK_FALSE(lay_out_supports(under_table(), layers, kBuildArea, {}, source.get_token()));
}

TEST_CASE("Supports under random boxes are clear, inside the build area, steep and connected") {
  CHECK(rc::check([] {
    // The boxes are one above the other or side by side: a place within another box is on no surface.
    models::Facets all;
    std::vector<SupportContact> contacts;
    for (std::int64_t i = draw(1, 4); i > 0; --i) {
      const auto x = static_cast<float>(-20 + 10 * (i - 1)), y = static_cast<float>(draw_real(-13, 7));
      const auto z = static_cast<float>(draw_real(0.5, 8)), w = static_cast<float>(draw_real(1, 9.5));
      const auto d = static_cast<float>(draw_real(1, 8)), under = static_cast<float>(draw_real(0, 0.5 * z));
      all = together(std::move(all), models::box({x, y, z}, {x + w, y + d, z + 1}));
      if (under > 0.1F) all = together(std::move(all), models::box({x, y, 0}, {x + w, y + d, under}));
      for (std::int64_t k = draw(0, 4); k > 0; --k)
        contacts.push_back(contact(draw_real(x, x + w), draw_real(y, y + d), z));
    }
    const Supports supports = supports_for(all, contacts);
    RC_ASSERT(supports.contacts.size() + supports.unheld.size() + supports.over_gaps.size() ==
              contacts.size());
    if (!supports.structure) return;
    RC_ASSERT(testing::least_clearance(supports, all, {}) >= 0.5 - kLooks_mm);
    RC_ASSERT(testing::is_within(supports, kBuildArea));
    RC_ASSERT(testing::is_steep(supports));
    RC_ASSERT(testing::is_connected(supports, all));
  }));
}
