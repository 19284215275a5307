#include "daemon/prepare/model_orientation.hpp"

#include <nlohmann/json.hpp>

#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr Millimeters kAny{1000};

ModelOrientation found(const models::Facets& facets, const OrientationTicket& asked = {}) {
  ModelTicket ticket;
  ticket.orientation = asked;
  return find_orientation(facets, ticket, {{kAny, kAny, kAny}, Scale{}, {}}).value();
}

models::Facets on_its_point() {
  models::Facets cone = models::cone(6, 20, 48);
  orient(cone, {.up = Direction{0, 0, -1}});
  return cone;
}

}  // namespace

TEST_CASE("A chosen orientation is described with its figures and with those of the model as drawn") {
  CHECK(describe(found(on_its_point())) ==
        "0, 0, -1 points up (auto): no overhangs, 20.00 mm high, largest layer 113 mm², stands by itself; as "
        "drawn: about 7 contacts, 0.12 ml of supports, 20.00 mm high, largest layer 113 mm²");
  CHECK(describe(found(models::box({0, 0, 0}, {10, 10, 10}), {OrientationPreset::Clean, {}})) ==
        "stays as drawn (clean): no overhangs, 10.00 mm high, largest layer 100 mm², stands by itself");
}

TEST_CASE("The description reports touched surfaces and a model that does not fit") {
  OrientationFigures figures;
  figures.contacts = 1.2;
  figures.touched_mm2 = 12;
  figures.fits = false;
  CHECK(describe(figures) ==
        "about 2 contacts, 0.00 ml of supports, 0.00 mm high, largest layer 0 mm², touches 12 mm² of the "
        "surfaces to be kept clean, does not fit into the machine");
}

TEST_CASE("The description and the report say that a model carries supports in its file") {
  ModelOrientation orientation;
  orientation.choice.ranked.emplace_back();
  orientation.choice.own_supports = true;
  CHECK(describe(orientation) ==
        "stays as drawn (auto): the model carries supports in its file, no overhangs, 0.00 mm high, largest "
        "layer "
        "0 mm²");
  CHECK(orientation_json(orientation)["own_supports"] == true);
  orientation.choice.ranked.insert(orientation.choice.ranked.begin(), OrientationFigures{})->up = {1, 0, 0};
  CHECK(describe(orientation)
            .starts_with("1, 0, 0 points up (auto): the supports that the model carries in its file are "
                         "turned as well, no overhangs"));
}

TEST_CASE("A direction is printed in thousandths, without a minus in front of 0") {
  CHECK(text_of({0.70710678, -0.0001, -1}) == "0.707, 0, -1");
}

TEST_CASE("The report lists the best orientations, the chosen one first") {
  const ModelOrientation orientation = found(on_its_point());
  const nlohmann::ordered_json json = orientation_json(orientation);
  CHECK(json["preset"] == "auto");
  CHECK(json["as_drawn"] == false);
  REQUIRE(json["alternatives"].size() == kMaxReported);
  CHECK(json["alternatives"][0]["up"] == nlohmann::ordered_json{0, 0, -1});
  CHECK(json["alternatives"][0]["stands"] == true);
  CHECK(json["alternatives"][0]["tried"] == true);
}

TEST_CASE("A model with fit fits the machine, however large it is in its file") {
  ModelTicket ticket;
  ticket.orientation.emplace();
  ticket.fit = true;
  const Millimeters small{1};
  const auto fitted = find_orientation(on_its_point(), ticket, {{small, small, small}, Scale{}, {}});
  CHECK(fitted.value().choice.chosen().fits);
  ticket.fit = false;
  CHECK_FALSE(find_orientation(on_its_point(), ticket, {{small, small, small}, Scale{}, {}})
                  .value()
                  .choice.chosen()
                  .fits);
}

TEST_CASE("A stopped search returns no orientation") {
  std::stop_source stop;
  stop.request_stop();
  ModelTicket ticket;
  ticket.orientation.emplace();
  CHECK_FALSE(find_orientation(on_its_point(), ticket, {{kAny, kAny, kAny}, Scale{}, {}}, stop.get_token())
                  .has_value());
}

TEST_CASE("An orientation is searched only if the ticket leaves it to contourd") {
  const models::Facets cone = on_its_point();
  CHECK(testing::contract_broken_by([&] {
          (void)find_orientation(cone, ModelTicket{}, {{kAny, kAny, kAny}, Scale{}, {}});
        }) == "the ticket leaves the orientation to contourd, and there is a facet");
}
