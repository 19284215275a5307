#include "daemon/placement/drain_holes.hpp"

#include "daemon/placement/model_turn.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"

namespace {

const DisplayGeometry kSquareDisplay{Pixels{300}, Pixels{300}, Micrometers{100.0}};

ModelTicket ticket_with(const DrainHole& hole) {
  ModelTicket ticket;
  ticket.drain = {hole};
  return ticket;
}

// Tolerance in mm: single floats after a few operations, about a hundred times their last bit at 10 mm.
bool near(double a, double b) {
  return std::fabs(a - b) < 1e-4;
}
bool near(const PlatePoint& a, const PlatePoint& b) {
  return near(a.x, b.x) && near(a.y, b.y) && near(a.z, b.z);
}

// Returns the refusal of a hole in a block of 10 x 10 x 10 mm from (0, 0, 0); empty if the hole is accepted.
std::string refusal_of(const DrainHole& hole, std::chrono::seconds time = std::chrono::hours(1)) {
  const ModelTicket ticket = ticket_with(hole);
  const auto index = std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {10, 10, 10}));
  const PlateModel model{{index}, {PixelMap::true_scale(kSquareDisplay, {5, 5})}};
  const auto cylinders = drain_cylinders(ticket, {}, {});
  HoleSearch search{{kSquareDisplay, AntiAliasing::On}, {}, MaskBudget::Clock::now() + time};
  for (std::int64_t layer = 0; layer < 20; ++layer)
    search.heights.emplace_back(500'000 * layer + 250'000);
  return testing::message_of<JobRefused>([&] {
    refuse_holes_beside({model, ticket, cylinders}, "the model", search);
  });
}

std::string refusal_of_scaled(ModelTicket ticket, double scale) {
  ticket.scale = Scale{scale};
  return testing::message_of<JobRefused>([&] { (void)(drain_cylinders(ticket, *ticket.scale, {})); });
}

}  // namespace

TEST_CASE("A hole reaches from half a diameter before its position to its depth, along any direction") {
  const auto cylinders = drain_cylinders(ticket_with({1, 2, 3, {0, 0, -7}, 2, 5}), {}, {});
  REQUIRE(cylinders.size() == 1);
  CHECK(near(cylinders[0].lower, {1, 2, -2}));
  CHECK(near(cylinders[0].upper, {1, 2, 4}));
  CHECK(cylinders[0].lower_radius_mm == 1);
  CHECK(cylinders[0].upper_radius_mm == 1);
  const auto oblique = drain_cylinders(ticket_with({0, 0, 0, {3, 0, 4}, 0.002, 5}), {}, {});
  CHECK(std::fabs(oblique[0].upper.x - 3) < 1e-3);
  CHECK(std::fabs(oblique[0].upper.z - 4) < 1e-3);
}

TEST_CASE("A hole's direction may be a vector of any length") {
  for (const double length : {1e-300, 5e-324, 1e308}) {
    const auto cylinders = drain_cylinders(ticket_with({1, 2, 3, {0, length, -length}, 2, 5}), {}, {});
    REQUIRE(cylinders.size() == 1);
    CHECK(near(cylinders[0].lower, {1, 2 + 5 * std::sqrt(0.5), 3 - 5 * std::sqrt(0.5)}));
  }
}

TEST_CASE("A hole is turned and scaled as its model is") {
  ModelTicket ticket = ticket_with({1, 0, 0, {1, 0, 0}, 2, 3});
  ticket.rotation = {0, -90, 0};  // x points up afterwards
  ticket.scale = Scale{2};
  const Scale shrinkage(1.01);
  const auto cylinders = drain_cylinders(ticket, *ticket.scale, shrinkage);
  CHECK(near(cylinders[0].lower, {0, 0, 0}));
  CHECK(near(cylinders[0].upper, {0, 0, 8.08}));
  CHECK(near(cylinders[0].lower_radius_mm, 2.02));
  // A facet of the model at the end of the hole is moved to the same place.
  std::vector<Facet> facets{{{Vertex{4, 0, 0}, Vertex{4, 0, 0}, Vertex{4, 0, 0}}}};
  turn_and_scale(facets, ticket, shrinkage);
  CHECK(
      near(cylinders[0].upper, {facets[0].vertices[0].x, facets[0].vertices[0].y, facets[0].vertices[0].z}));
}

TEST_CASE("If the factors differ by axis, the diameter is scaled by their mean") {
  ModelTicket ticket = ticket_with({0, 0, 0, {0, 0, 1}, 2, 5});
  ticket.scale = Scale{1, 2, 3};
  const auto cylinders = drain_cylinders(ticket, *ticket.scale, {});
  CHECK(near(cylinders[0].upper, {0, 0, 15}));
  CHECK(near(cylinders[0].lower_radius_mm, 2));
}

TEST_CASE("The holes of a model with fit are turned, then enlarged with it") {
  ModelTicket ticket = ticket_with({1, 0, 0, {0, 0, 1}, 2, 5});
  ticket.fit = true;
  ticket.up = Direction{0, 0, 1};
  const auto cylinders = drain_cylinders(ticket, Scale{4}, {});
  CHECK(near(cylinders[0].lower, {4, 0, -4}));
  CHECK(near(cylinders[0].upper, {4, 0, 20}));
  CHECK(near(cylinders[0].lower_radius_mm, 4));
}

TEST_CASE("A hole that has no length once it is scaled is refused") {
  ModelTicket ticket = ticket_with({90'000, 0, 0, {1, 0, 0}, 0.001, 0.001});
  CHECK(lacking(refusal_of_scaled(ticket, 1),
                {"drain hole 1 at 90000, 0, 0 mm is too small", "0.001 mm deep"}) == "");
}

TEST_CASE("A hole that is too far away or too large once it is scaled is refused with its place") {
  const ModelTicket far = ticket_with({90'000, 0, 0, {1, 0, 0}, 2, 5});
  CHECK(refusal_of_scaled(far, 11) == "");
  CHECK(lacking(refusal_of_scaled(far, 12), {"drain hole 1 at 90000, 0, 0 mm is too far away", "1e+06 mm"}) ==
        "");
  const ModelTicket wide = ticket_with({0, 0, 0, {0, 0, 1}, 90'000, 1});
  CHECK(lacking(refusal_of_scaled(wide, 30), {"too large", "2.7e+06 mm wide"}) == "");
  for (const double scale : {1e6, 1e30, 1e300})
    CHECK_FALSE(refusal_of_scaled(far, scale).empty());
}

TEST_CASE("A hole that removes something is accepted, wherever it begins") {
  CHECK(refusal_of({5, 5, 0, {0, 0, 1}, 2, 3}).empty());
  CHECK(refusal_of({0, 5, 5, {1, 0, 0}, 2, 3}).empty());
  CHECK(refusal_of({5, 5, 5, {1, 1, 1}, 1, 1}).empty());
}

TEST_CASE("A hole that misses the model is refused with the positions of both") {
  CHECK(refusal_of({-20, 5, 5, {1, 0, 0}, 2, 3}) ==
        "drain hole 1 of the model misses it: the hole starts at -20, 5, 5 mm, is 2 mm wide and 3 mm deep, "
        "and removes nothing; as printed, it reaches from -21.00, 5.00, 5.00 to -17.00, 5.00, 5.00 mm, and "
        "the model from 0.00, 0.00, 0.00 to 10.00, 10.00, 10.00 mm");
  // Holes that point away from the model, begin above it, or lie between the heights at which layers are cut.
  CHECK_FALSE(refusal_of({0, 5, 5, {-1, 0, 0}, 0.001, 3}).empty());
  CHECK_FALSE(refusal_of({5, 5, 40, {0, 0, -1}, 2, 3}).empty());
  CHECK_FALSE(refusal_of({5, 5, 2.5, {1, 0, 0}, 0.2, 3}).empty());
}

TEST_CASE("A hole is accepted if the time to check it runs out") {
  CHECK(refusal_of({-20, 5, 5, {1, 0, 0}, 2, 3}, std::chrono::seconds(0)).empty());
}

TEST_CASE("A ticket without holes gives no cylinders and no section source") {
  CHECK(drain_cylinders({}, {}, {}).empty());
  CHECK(holes_of({}) == nullptr);
}
