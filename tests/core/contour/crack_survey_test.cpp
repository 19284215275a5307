#include "core/contour/crack_survey.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"

namespace {

// The middles of 1 mm layers.
std::vector<Nanometers> layers(int count) {
  std::vector<Nanometers> heights;
  for (int i = 0; i < count; ++i)
    heights.push_back(Nanometers{i * std::int64_t{1'000'000} + 500'000});
  return heights;
}

// A slab of 3 mm and a tower of 4 mm on top, whose front has been moved away or is missing.
models::Facets tower(float crack, bool missing) {
  models::Facets facets = models::box({0, 0, 5}, {10, 10, 8});
  models::Facets upper = models::box({0, 0, 8}, {4, 4, 12});
  for (Facet& facet : upper) {
    const auto& v = facet.vertices;
    const bool front = v[0].y == 0 && v[1].y == 0 && v[2].y == 0;
    if (front && missing) continue;
    if (front) {
      for (Vertex& each : facet.vertices)
        each.y -= crack;
    }
    facets.push_back(facet);
  }
  return facets;
}

StandingModel standing(const models::Facets& facets, Elevation elevation = {}) {
  return {std::make_shared<const HeightIndex>(facets), elevation};
}

}  // namespace

TEST_CASE("A sound model has no cracks in any layer") {
  const CrackSurvey survey = survey_cracks(standing(tower(0, false)), layers(7), kPixel);
  CHECK(survey.open_layers == 0);
  CHECK_FALSE(survey.first_open.has_value());
  CHECK(survey.cracks == LayerCracks{});
}

TEST_CASE("Layers with gaps within the tolerance are counted but not open") {
  const CrackSurvey survey = survey_cracks(standing(tower(0.02F, false)), layers(7), kPixel);
  CHECK(survey.open_layers == 0);
  CHECK(survey.cracks.gaps_closed == 4 * 2);
  CHECK(survey.cracks.widest_gap.count() == testing::Approx(0.02).epsilon(1e-5));
}

TEST_CASE("The first layer with a hole is reported and the layers with holes are counted") {
  const CrackSurvey survey = survey_cracks(standing(tower(0, true)), layers(7), kPixel);
  CHECK(survey.first_open == 3);
  CHECK(survey.open_layers == 4);
  CHECK(survey.cracks.open_chains == 4);
  CHECK(survey.cracks.widest_gap == Millimeters{4});
  CHECK(survey.wide_layers == 4);
  CHECK(survey_cracks(standing(tower(0, true)), layers(7), Millimeters{0.5}).wide_layers == 0);
}

TEST_CASE("Layers whose contours close only if a facet is turned back are guesses") {
  models::Facets facets = tower(0, false);
  // A facet of the upper front, from its foot to its top.
  const auto turned = std::ranges::find_if(facets, [](const Facet& facet) {
    return std::ranges::all_of(facet.vertices, [](const Vertex& v) { return v.y == 0 && v.z >= 8; });
  });
  REQUIRE(turned != facets.end());
  std::swap(turned->vertices[0], turned->vertices[1]);
  // Moved away from its neighbours, so that they do not show how it is turned.
  for (Vertex& v : turned->vertices)
    v.y -= 0.001F;
  const CrackSurvey survey = survey_cracks(standing(facets), layers(7), kPixel);
  CHECK(survey.first_open == 3);
  CHECK(survey.open_layers == 4);
  CHECK(survey.cracks.open_chains == 0);
  CHECK(survey.cracks.turned_chains == 4);
}

TEST_CASE("The open layers of a model above the plate are higher by the same distance") {
  const Elevation raised(Nanometers{5'000'000});
  const CrackSurvey low = survey_cracks(standing(tower(0, true)), layers(7), kPixel);
  const CrackSurvey high = survey_cracks(standing(tower(0, true), raised), layers(12), kPixel);
  REQUIRE(low.first_open);
  CHECK(high.first_open == *low.first_open + 5);
  CHECK(high.open_layers == low.open_layers);
  CHECK(high.cracks == low.cracks);
}
