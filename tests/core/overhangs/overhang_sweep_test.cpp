#include "core/overhangs/overhang_sweep.hpp"

#include <rapidcheck.h>

#include <cstdio>
#include <filesystem>
#include <stop_token>

#include "core/formats/model_reader.hpp"
#include "tests/catch.hpp"
#include "tests/core/overhangs/held_fixture.hpp"
#include "tests/core/section_fixture.hpp"

using models::together;

namespace {

// The thickness of a sweep's layer and the side of its pixels.
constexpr double kStepMm = 0.05;
constexpr double kStrengthMm2 = 11.1;

double distance_mm(const SupportContact& contact, double x, double y) {
  return std::hypot(contact.place.x - x, contact.place.y - y);
}

// Returns the distance from (x, y) to the nearest contact; infinite if there is none.
double nearest_mm(const std::vector<SupportContact>& contacts, double x, double y) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const SupportContact& contact : contacts)
    nearest = std::min(nearest, distance_mm(contact, x, y));
  return nearest;
}

std::size_t count(const std::vector<SupportContact>& contacts, ContactCause cause) {
  return static_cast<std::size_t>(std::ranges::count(contacts, cause, &SupportContact::cause));
}

bool all_at_height(const std::vector<SupportContact>& contacts, double z_mm) {
  // Vertices are floats.
  return std::ranges::all_of(
      contacts, [z_mm](const SupportContact& each) { return std::fabs(each.place.z - z_mm) < 1e-4; });
}

bool none_overloaded(const std::vector<SupportContact>& contacts) {
  return std::ranges::all_of(contacts,
                             [](const SupportContact& each) { return each.load_mm2 <= kStrengthMm2; });
}

// Returns a wedge on the plate, 12 mm deep, whose underside rises from x = 2 to the right over a foot 4 mm
// wide.
models::Facets rising_underside(double rise_for_each_mm) {
  const std::array<Point, 5> outline{{{-2, 0},
                                      {2, 0},
                                      {14, 12 * rise_for_each_mm},
                                      {14, 12 * rise_for_each_mm + 1},
                                      {-2, 12 * rise_for_each_mm + 1}}};
  return prism(outline, 12);
}

std::ptrdiff_t count_above(const std::vector<SupportContact>& contacts, double z_mm) {
  return std::ranges::count_if(contacts, [&](const SupportContact& each) { return each.place.z > z_mm; });
}

}  // namespace

TEST_CASE("A model that stands on the plate and gets no wider needs no contact") {
  CHECK(contacts_of(models::box({-5, -5, 0}, {5, 5, 10}), 0).empty());
  CHECK(contacts_of(models::cone(8, 12, 60), 0).empty());
}

TEST_CASE("Material rests on the plate where the gap beneath it is one that bottom layers close") {
  auto base = models::box({-15, -10, 0}, {15, 10, 6});
  for (Facet& facet : base) {
    for (Vertex& vertex : facet.vertices)
      vertex.z += 0.009F * (vertex.x + 15);  // 0.27 mm
  }
  CHECK(contacts_of(base, 0).empty());
  SupportSettings settings;
  settings.closed_gap = Millimeters{0.1};
  CHECK_FALSE(contacts_of(base, 0, settings).empty());
  // An arm beside a block, and a block of its own.
  const auto beside_a_block = [](float left, float height) {
    return together(models::box({-10, -5, 0}, {0, 5, 10}), models::box({left, -5, height}, {10, 5, 10}));
  };
  for (const float left : {-1.0F, 2.0F}) {
    CHECK(contacts_of(beside_a_block(left, 0.2F), 0).empty());
    CHECK(contacts_of(beside_a_block(left, 0.4F), 0).size() > 5);
  }
}

TEST_CASE("A lifted ball is held at its lowest point, from straight beneath, and around it") {
  const auto contacts = contacts_of(models::globe(6, 40, 80), 5);
  REQUIRE(contacts.size() > 4);
  const SupportContact& lowest = contacts.front();
  CHECK(lowest.cause == ContactCause::Island);
  // The contact may be a pixel off the middle, and the ball consists of facets.
  CHECK(lowest.place.z == testing::Approx(5).margin(0.005));
  CHECK(distance_mm(lowest, 0, 0) < 0.1);
  CHECK(lowest.outward.z < -0.99);
  CHECK(count(contacts, ContactCause::Island) == 1);
  CHECK(none_overloaded(contacts));
}

TEST_CASE("A contact's normal has length 1, points away from the model and never up") {
  for (const SupportContact& contact : contacts_of(models::globe(6, 40, 80), 5)) {
    const Direction& out = contact.outward;
    CHECK(std::fabs(out.x * out.x + out.y * out.y + out.z * out.z - 1) < 1e-9);
    CHECK(out.z <= 0);
    // Compared with the ball's own normal: facets are 4.5 degrees wide, and the sum of the facets around is
    // within 6 degrees.
    const double along =
        (contact.place.x * out.x + contact.place.y * out.y + (contact.place.z - 11) * out.z) / 6;
    CHECK(along > 0.994);
  }
}

TEST_CASE("No point under a table is farther from a leg or a contact than resin may bridge") {
  models::Facets table = models::box({-10, -10, 10}, {10, 10, 12});
  for (const float x : {-10.0F, 8.0F}) {
    for (const float y : {-10.0F, 8.0F}) {
      const auto leg = models::box({x, y, 0}, {x + 2, y + 2, 11});
      table.insert(table.end(), leg.begin(), leg.end());
    }
  }
  const auto contacts = contacts_of(table, 0);
  CHECK(all_at_height(contacts, 10));
  CHECK(count(contacts, ContactCause::Overhang) == contacts.size());
  CHECK(none_overloaded(contacts));
  // 384 mm2 divided into discs of 1.65 mm radius: 54 in a honeycomb arrangement, 71 in a chessboard
  // arrangement.
  CHECK(contacts.size() <= 88);
  double farthest = 0;
  for (double x = -9.9; x < 10; x += 0.1) {
    for (double y = -9.9; y < 10; y += 0.1) {
      const double leg = std::hypot(std::max(0.0, 8 - std::fabs(x)), std::max(0.0, 8 - std::fabs(y)));
      farthest = std::max(farthest, std::min(leg, nearest_mm(contacts, x, y) - 0.2));
    }
  }
  // The tolerance is a pixel's diagonal.
  CHECK(farthest <= 1.5 + 0.071);
}

TEST_CASE("The arms of a T are held where they begin, its stem is not") {
  const auto contacts =
      contacts_of(together(models::box({-2, -2, 0}, {2, 2, 11}), models::box({-10, -2, 10}, {10, 2, 12})), 0);
  CHECK(all_at_height(contacts, 10));
  for (const double side : {-1.0, 1.0}) {
    for (double x = 3.5; x < 10; x += 0.25)
      CHECK(nearest_mm(contacts, side * x, 0) < 1.72);
  }
  CHECK(
      std::ranges::all_of(contacts, [](const SupportContact& each) { return std::fabs(each.place.x) > 3; }));
  CHECK(contacts.size() <= 18);
}

TEST_CASE("A bridge is held only where it is longer than the resin bridges from both sides") {
  const auto bridge = [](float gap) {
    return together(together(models::box({-gap / 2 - 3, -3, 0}, {-gap / 2, 3, 5}),
                             models::box({gap / 2, -3, 0}, {gap / 2 + 3, 3, 5})),
                    models::box({-gap / 2 - 1, -3, 4}, {gap / 2 + 1, 3, 6}));
  };
  CHECK(contacts_of(bridge(2.9F), 0).empty());
  const auto contacts = contacts_of(bridge(4), 0);
  REQUIRE_FALSE(contacts.empty());
  for (const SupportContact& contact : contacts)
    CHECK(std::fabs(contact.place.x) < 0.6);  // only a strip of 1 mm is too far from both sides
  SupportSettings stiff;
  stiff.bridge = Millimeters{2.1};
  CHECK(contacts_of(bridge(4), 0, stiff).empty());
}

TEST_CASE("A ball that begins beside a post in the air is an island there") {
  auto ball = models::globe(1, 20, 40);
  models::translate(ball, 3, 1, 7);
  const auto contacts = contacts_of(together(models::box({-4, -4, 0}, {2.5F, 4, 9}), ball), 0);
  REQUIRE(contacts.size() == 1);
  CHECK(contacts.front().cause == ContactCause::Island);
  CHECK(std::fabs(contacts.front().place.z - 6) < 0.005);
  CHECK(distance_mm(contacts.front(), 3, 1) < 0.1);
}

TEST_CASE("Stairs seen from below need no contact at 45 degrees, but flatter ones do") {
  const auto stairs = [](float out) {
    models::Facets all = models::box({-2, -3, 0}, {2, 3, 1.1F});
    for (int i = 1; i < 8; ++i) {
      const auto rise = static_cast<float>(i);
      all = together(all, models::box({-2, -3, rise}, {2 + out * rise, 3, rise + 1.1F}));
    }
    return all;
  };
  CHECK(contacts_of(stairs(1), 0).empty());
  CHECK(contacts_of(stairs(2.5F), 0).size() >= 7);
}

TEST_CASE("Each finger of a comb that points down is held in its middle") {
  models::Facets comb = models::box({-6, -0.15F, 5}, {6, 0.15F, 7});
  for (int i = 0; i < 9; ++i) {
    const auto x = static_cast<float>(1.4 * (i - 4));
    comb = together(comb, models::box({x - 0.15F, -0.15F, 0}, {x + 0.15F, 0.15F, 5.5F}));
  }
  const auto contacts = contacts_of(comb, 5);
  CHECK(all_at_height(contacts, 5));
  REQUIRE(contacts.size() == 9);
  for (int i = 0; i < 9; ++i)
    CHECK(nearest_mm(contacts, 1.4 * (i - 4), 0) < 0.06);  // half a pixel's diagonal, and rounding
}

TEST_CASE("An underside that rises gently is held again and again, a steep one never") {
  CHECK(count(contacts_of(rising_underside(1.1), 0), ContactCause::Overhang) == 0);
  const auto gentle = contacts_of(rising_underside(0.36), 0);  // 20 degrees
  const auto gentler = contacts_of(rising_underside(0.18), 0);
  CHECK(gentle.size() >= 2);
  CHECK(gentler.size() > gentle.size());
  // The reach is at most 3.2 mm plus a millimetre for each millimetre of height.
  for (double x = 6.5; x < 13.9; x += 0.5)
    CHECK(nearest_mm(gentler, x, 0) < 5);
  CHECK(none_overloaded(gentle));
}

TEST_CASE("No place gets two contacts, however wide the tips are") {
  for (const double tip_mm : {0.4, 2.0, 5.0, 10.0}) {
    const SupportSettings settings{.tip_diameter = Millimeters{tip_mm},
                                   .pillar_diameter = Millimeters{20},
                                   .foot_diameter = Millimeters{30}};
    std::vector<PlatePoint> places;
    for (const SupportContact& contact : contacts_of(models::globe(10, 24, 48), 5, settings))
      places.push_back(contact.place);
    CHECK_FALSE(places.empty());
    CHECK(places.size() < kMostContacts);
    const auto key = [](const PlatePoint& place) { return std::tuple(place.x, place.y, place.z); };
    std::ranges::sort(places, {}, key);
    CHECK(std::ranges::adjacent_find(places) == places.end());
  }
}

TEST_CASE("Contacts lie on the surface, between the sweep's layers") {
  const auto contacts = contacts_of(rising_underside(0.18), 0);
  REQUIRE_FALSE(contacts.empty());
  for (const SupportContact& contact : contacts) {
    CHECK(std::fabs(contact.place.z - (contact.place.x - 2) * 0.18) < 1e-4);
    CHECK(std::fabs(contact.outward.x - 0.18 / std::hypot(1, 0.18)) < 1e-4);
  }
}

TEST_CASE("Overlapping shells are held like one body") {
  const auto whole = models::box({-4, -4, 0}, {4, 4, 4});
  const auto shells =
      together(together(models::box({-4, -4, 0}, {1, 4, 4}), models::box({-1, -4, 0}, {4, 4, 4})),
               models::box({-2, -2, 1}, {2, 2, 3}));
  CHECK(contacts_of(shells, 5).size() == contacts_of(whole, 5).size());
  CHECK(all_at_height(contacts_of(shells, 5), 5));
}

TEST_CASE("A speck gets no contact, but a part of several layers gets one") {
  const auto block = models::box({-5, -5, 0}, {5, 5, 10});
  const auto beside = [&](float side, float height) {
    return together(block, models::box({7, 0, 4.01F}, {7 + side, side, 4.01F + height}));
  };
  CHECK(contacts_of(beside(0.06F, 0.04F), 0).empty());
  CHECK(contacts_of(beside(0.3F, 0.3F), 0).size() == 1);
  CHECK(contacts_of(beside(0.06F, 1), 0).size() == 1);
}

TEST_CASE("A body that is wide high up has as many contacts as its peel requires") {
  // A pyramid on its point, 45 degrees steep, so nothing overhangs. Its widest layer is 24 by 24 mm.
  const std::array<Point, 4> profile{{{0, 0}, {17, 17}, {17, 18}, {0, 18}}};
  const auto contacts = contacts_of(models::lathe(profile, 4), 5);
  CHECK(contacts.size() >= 26);  // half of 578 mm2 by 11.1
  CHECK(contacts.size() <= 40);
  CHECK(count(contacts, ContactCause::Peel) > 0);
  CHECK(none_overloaded(contacts));
  SupportSettings strong;
  strong.tip_holds_mm2 = 50;
  CHECK(contacts_of(models::lathe(profile, 4), 5, strong).size() < contacts.size() / 2);
}

TEST_CASE("Contacts come from the plate up, the same every time, and on a mirrored display") {
  auto ball = models::globe(3, 30, 60);
  models::translate(ball, 5, 2, 3);
  const auto model = together(ball, models::box({-8, -4, 2}, {0, 3, 4}));
  const auto contacts = contacts_of(model, 5);
  REQUIRE(contacts.size() > 5);
  CHECK(std::ranges::is_sorted(contacts, {}, [](const SupportContact& each) { return each.place.z; }));
  CHECK(contacts_of(model, 5) == contacts);
  SupportRequest mirrored = held_request(model, 5);
  mirrored.display.mirror_x = true;
  mirrored.models.front().copies = {PixelMap::true_scale(mirrored.display, {0, 0})};
  CHECK(contacts_of(mirrored) == contacts);
}

TEST_CASE("No contact below a level surface holds only a sliver that the others leave") {
  constexpr double kSlackMm = 0.15;
  for (const double radius : {2.0, 3.3, 4.1, 5.0, 6.6, 7.4, 9.0}) {
    // A cup, mouth down, and a disc on supports.
    const std::array<Point, 6> cup{
        {{0, 6}, {radius, 6}, {radius, 0}, {radius + 2, 0}, {radius + 2, 8}, {0, 8}}};
    const std::array<Point, 4> disc{{{0, 6}, {radius, 6}, {radius, 8}, {0, 8}}};
    for (const bool has_wall : {true, false}) {
      INFO("radius " << radius << " mm, " << (has_wall ? "with a wall" : "without a wall"));
      const auto contacts =
          has_wall ? contacts_of(models::lathe(cup, 96), 0) : contacts_of(models::lathe(disc, 96), 6);
      for (const SupportContact& contact : contacts)
        CHECK(contact.load_mm2 > kSlackMm * kSlackMm);
      for (double x = -radius + 0.1; x < radius; x += 0.1) {
        for (double y = -radius + 0.1; y < radius; y += 0.1) {
          const double from_middle = std::hypot(x, y);
          if (from_middle > radius || (has_wall && radius - from_middle < 1.5 + kSlackMm)) continue;
          REQUIRE(nearest_mm(contacts, x, y) < 1.7 + kSlackMm);
        }
      }
    }
  }
}

TEST_CASE("An observer sees every layer from the plate to the models' top") {
  testing::CountingObserver observer;
  REQUIRE(find_overhangs(held_request(models::box({-2, -2, 0}, {2, 2, 3}), 1), observer));
  CHECK(observer.step == Nanometers{50'000});
  CHECK(observer.display.width_mm() >= 40);
  REQUIRE(observer.heights.size() == 80);
  for (std::size_t i = 0; i < observer.heights.size(); ++i)
    CHECK(observer.heights[i] == Nanometers{25'000 + 50'000 * static_cast<std::int64_t>(i)});
}

TEST_CASE("An island that only the print's layers cut is held") {
  const auto model =
      together(models::box({-2, -2, 0}, {2, 2, 1}), models::box({3, -1, 1.03F}, {5, 1, 1.07F}));
  SupportRequest request = held_request(model, 0);
  CHECK(contacts_of(request).empty());
  request.printed.thicknesses.assign(60, Nanometers{20'000});
  const auto contacts = contacts_of(request);
  CHECK(count(contacts, ContactCause::Island) == contacts.size());
  CHECK_FALSE(contacts.empty());
  CHECK(all_at_height(contacts, 1.03));
}

TEST_CASE("A part whose neck the compensation closes is held, and one that it leaves is not") {
  const auto model =
      together({models::box({-2, -2, 0}, {2, 2, 1}), models::box({-0.08F, -0.08F, 1}, {0.08F, 0.08F, 2}),
                models::box({-0.5F, -0.5F, 2}, {0.5F, 0.5F, 4})});
  SupportRequest request = held_request(model, 0);
  CHECK(contacts_of(request).empty());
  request.printed.compensation.growth = Micrometers{-30.0};
  CHECK(contacts_of(request).empty());
  request.printed.compensation.growth = Micrometers{-100.0};
  const auto contacts = contacts_of(request);
  REQUIRE(contacts.size() == 1);
  CHECK(contacts.front().cause == ContactCause::Island);
  CHECK(all_at_height(contacts, 2));
}

TEST_CASE("An elephant's foot that erases the bottom of a wall leaves an island above the closed gap") {
  const auto wall = models::box({-5, -0.1F, 0}, {5, 0.1F, 4});
  SupportRequest request = held_request(wall, 0);
  request.printed.compensation = {Micrometers{}, Micrometers{200.0}, Nanometers{2'000'000}};
  const auto contacts = contacts_of(request);
  REQUIRE_FALSE(contacts.empty());
  CHECK(contacts.front().cause == ContactCause::Island);
  request.printed.compensation.elephant_foot_height = Nanometers{400'000};
  CHECK(contacts_of(request).empty());
}

TEST_CASE("An observer of layers of any thickness sees the material at equal steps") {
  SupportRequest request = held_request(models::box({-2, -2, 0}, {2, 2, 0.18F}), 0);
  request.printed.thicknesses = {Nanometers{100'000}, Nanometers{40'000}, Nanometers{40'000}};
  testing::CountingObserver observer;
  REQUIRE(find_overhangs(request, observer));
  CHECK(observer.step == Nanometers{40'000});
  CHECK(observer.heights ==
        std::vector{Nanometers{20'000}, Nanometers{60'000}, Nanometers{100'000}, Nanometers{140'000}});
}

TEST_CASE("A sweep stops before the next layer on request") {
  class Stopper final : public LayerObserver {
   public:
    void begin(const DisplayGeometry&, Nanometers) override {}
    void layer(Nanometers, const MaskRuns&) override {
      if (++layers == 7) source.request_stop();
    }
    std::stop_source source;
    int layers = 0;
  };
  Stopper stopper;
  const auto request = held_request(models::box({-2, -2, 0}, {2, 2, 3}), 1);
  CHECK_FALSE(find_overhangs(request, stopper, stopper.source.get_token()));
  CHECK(stopper.layers == 7);
}

TEST_CASE("Every box in the air is held from beneath, and no contact by more than its strength") {
  const bool held = rc::check([] {
    models::Facets all = models::box({-19, -19, 0}, {-18, -18, 1});
    std::vector<std::array<float, 4>> boxes;  // x, y, z, side
    for (int i = 0; i < 4; ++i) {
      const auto part = [](int most) { return static_cast<float>(*rc::gen::inRange(0, most)) / 100; };
      const float x = static_cast<float>(-14 + 8 * i), y = part(1000) - 5, z = 1 + part(500),
                  side = 0.2F + part(600);
      boxes.push_back({x, y, z, side});
      const auto box = models::box({x, y, z}, {x + side, y + side, z + 1});
      all.insert(all.end(), box.begin(), box.end());
    }
    const auto contacts = contacts_of(all, 0);
    RC_ASSERT(none_overloaded(contacts));
    for (const auto& [x, y, z, side] : boxes) {
      for (const double part : {0.1, 0.5, 0.9}) {
        // The bridging distance from the tip's rim, and a pixel's diagonal.
        RC_ASSERT(nearest_mm(contacts, x + part * side, y + part * side) <= 1.7 + kStepMm * 1.42);
      }
    }
  });
  CHECK(held);
}

TEST_CASE("Models of the shared folder get no more contacts than from PrusaSlicer, except against levers") {
  const std::filesystem::path folder = std::filesystem::path(CONTOURD_SHARED_DIR) / "models";
  if (!std::filesystem::exists(folder)) {
    std::puts("SKIPPED: the shared models are not there");
    return;
  }
  struct Row {
    const char* file;
    float scale;
    double lift_mm;
    std::size_t most;
  };
  // PrusaSlicer gives 14 contacts to the horse, whose legs lean on one tip each.
  for (const Row& row : {Row{"thingi-1063852.stl", 1, 5, 27}, Row{"pv-horse.stl", 200, 5, 25},
                         Row{"thingi-73416.stl", 1, 0, 90}, Row{"pv-turbineblade.stl", 1, 0, 14}}) {
    Model model = read_model_file(folder / row.file);
    const Bounds bounds = bounds_of(model.facets);
    for (Facet& facet : model.facets) {
      for (Vertex& v : facet.vertices)
        v = {(v.x - static_cast<float>(bounds.center().x)) * row.scale,
             (v.y - static_cast<float>(bounds.center().y)) * row.scale, v.z * row.scale};
    }
    SupportRequest request = held_request(model.facets, row.lift_mm);
    request.display = {Pixels{1920}, Pixels{1080}, Micrometers{50.0}};
    request.models.front().copies = {PixelMap::true_scale(request.display, {0, 0})};
    const auto contacts = contacts_of(request);
    INFO(row.file << ": " << contacts.size());
    CHECK(contacts.size() <= row.most);
    CHECK_FALSE(contacts.empty());
    CHECK(none_overloaded(contacts));
  }
}

TEST_CASE("A rod that leans is held along its length, and an upright one only at its end") {
  const auto rod_leaning_by = [](double degrees) {
    constexpr double kLength = 30, kHalfWidth = 2, kRadian = 57.29577951308232;
    const double up = std::cos(degrees / kRadian), across = std::sin(degrees / kRadian);
    const double low = kHalfWidth * across;  // the lowest corner lies at height 0
    const std::array<Point, 4> outline{
        {{kHalfWidth * up, low - kHalfWidth * across},
         {kHalfWidth * up + kLength * across, low - kHalfWidth * across + kLength * up},
         {-kHalfWidth * up + kLength * across, low + kHalfWidth * across + kLength * up},
         {-kHalfWidth * up, low + kHalfWidth * across}}};
    return prism(outline, 2 * kHalfWidth);
  };
  for (const double degrees : {20.0, 30.0, 45.0}) {
    const auto contacts = contacts_of(rod_leaning_by(degrees), 5);
    // The contacts' distances grow with the distance from the foot.
    CHECK(count_above(contacts, 5 + 10 * std::cos(degrees / 57.3)) >= 1);
    CHECK(contacts.size() <= 20);
    CHECK(none_overloaded(contacts));
  }
  CHECK(count_above(contacts_of(rod_leaning_by(0), 5), 5.1) == 0);
  CHECK(contacts_of(rod_leaning_by(0), 0).empty());
}
