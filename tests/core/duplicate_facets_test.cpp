#include "core/duplicate_facets.hpp"

#include <utility>

#include "tests/catch.hpp"
#include "tests/models/damage.hpp"
#include "tests/models/models.hpp"

using namespace contourd;

TEST_CASE("Models without duplicate facets are known as such") {
  CHECK_FALSE(may_have_duplicates({}));
  CHECK_FALSE(may_have_duplicates(models::box({0, 0, 0}, {1, 1, 1})));
  CHECK_FALSE(may_have_duplicates(models::sphere(10, 64)));
  CHECK_FALSE(may_have_duplicates(models::gyroid_sphere(10, 6, 24)));
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
    CHECK(may_have_duplicates(odd));
  }
}

TEST_CASE("A facet and the same turned the other way round are a wall, no duplicates") {
  models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  Facet turned = facets[0];
  std::swap(turned.vertices[1], turned.vertices[2]);
  facets.push_back(turned);
  CHECK_FALSE(may_have_duplicates(facets));
}

TEST_CASE("Zero and minus zero are the same place") {
  const Facet facet{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 1}}}};
  const Facet same{{{{-0.0F, 0, -0.0F}, {1, -0.0F, 0}, {-0.0F, 1, 1}}}};
  CHECK(may_have_duplicates(models::Facets{facet, same}));
}
