#include "core/duplicate_facets.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/height_index.hpp"
#include "tests/catch.hpp"
#include "tests/models/damage.hpp"
#include "tests/models/models.hpp"

using namespace contourd;

TEST_CASE("Models without duplicate facets are known as such") {
  CHECK(heights_of_duplicates({}).empty());
  CHECK(heights_of_duplicates(models::box({0, 0, 0}, {1, 1, 1})).empty());
  CHECK(heights_of_duplicates(models::sphere(10, 64)).empty());
  CHECK(heights_of_duplicates(models::gyroid_sphere(10, 6, 24)).empty());
}

TEST_CASE("A facet that is there twice is noticed, wherever it is and whichever vertex it begins with") {
  const models::Facets clean = models::gyroid_sphere(10, 6, 24);
  models::Dice dice(7);
  for (int i = 0; i < 100; ++i) {
    models::Facets odd = clean;
    const Facet chosen = clean[dice.below(clean.size())];
    const auto& [a, b, c] = chosen.vertices;
    const Facet same[] = {{{a, b, c}}, {{b, c, a}}, {{c, a, b}}};
    odd.insert(odd.begin() + static_cast<std::ptrdiff_t>(dice.below(clean.size())), same[i % 3]);
    const auto [low, high] = std::minmax({a.z, b.z, c.z});
    CHECK(heights_of_duplicates(odd) == std::vector<HeightRange>{{low, high}});
  }
}

TEST_CASE("A facet and the same turned the other way round are a wall, no duplicates") {
  models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  Facet turned = facets[0];
  std::swap(turned.vertices[1], turned.vertices[2]);
  facets.push_back(turned);
  CHECK(heights_of_duplicates(facets).empty());
}

TEST_CASE("Zero and minus zero are the same place") {
  const Facet facet{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 1}}}};
  const Facet same{{{{-0.0F, 0, -0.0F}, {1, -0.0F, 0}, {-0.0F, 1, 1}}}};
  CHECK(heights_of_duplicates(models::Facets{facet, same}) == std::vector<HeightRange>{{0, 1}});
}

TEST_CASE("Heights of duplicates are told apart where they are, and as one where they meet") {
  models::Facets facets;
  for (const float z : {7.0F, 0.0F, 1.0F, 3.0F, 8.5F, 7.5F}) {
    const Facet facet{{{{0, 0, z}, {1, 0, z}, {0, 1, z + 1}}}};
    facets.insert(facets.end(), {facet, facet});
  }
  CHECK(heights_of_duplicates(facets) == std::vector<HeightRange>{{0, 2}, {3, 4}, {7, 9.5F}});
  const HeightIndex model(facets);
  for (const double z : {0.0, 1.9, 3.0, 8.0, 9.4})
    CHECK(model.may_have_duplicates_at(z));
  for (const double z : {-0.1, 2.0, 2.9, 4.0, 6.9, 9.5})
    CHECK_FALSE(model.may_have_duplicates_at(z));
}
