#include "core/repair/mesh_soundness.hpp"

#include "tests/catch.hpp"
#include "tests/models/damage.hpp"
#include "tests/models/models.hpp"

TEST_CASE("Closed models are sound") {
  CHECK(is_sound({}));
  CHECK(is_sound(models::box({0, 0, 0}, {1, 1, 1})));
  CHECK(is_sound(models::sphere(10, 64)));
  CHECK(is_sound(models::gyroid_sphere(10, 6, 24)));
}

TEST_CASE("A duplicate facet is noticed, wherever it is and however it is turned") {
  const models::Facets clean = models::gyroid_sphere(10, 6, 24);
  models::Dice dice(7);
  for (int i = 0; i < 60; ++i) {
    models::Facets odd = clean;
    const Facet chosen = clean[dice.below(clean.size())];
    const auto& [a, b, c] = chosen.vertices;
    const Facet same[] = {{{a, b, c}}, {{b, c, a}}, {{c, a, b}}, {{a, c, b}}, {{c, b, a}}, {{b, a, c}}};
    odd.insert(odd.begin() + static_cast<std::ptrdiff_t>(dice.below(clean.size())), same[i % 6]);
    CHECK_FALSE(is_sound(odd));
  }
}

TEST_CASE("A missing, turned or moved facet is noticed") {
  const models::Facets clean = models::sphere(10, 20);
  models::Dice dice(3);
  for (int i = 0; i < 60; ++i) {
    const std::size_t chosen = dice.below(clean.size());
    models::Facets missing = clean, turned = clean, moved = clean;
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(chosen));
    std::swap(turned[chosen].vertices[0], turned[chosen].vertices[1]);
    moved[chosen].vertices[0].x += 1e-4F;
    CHECK_FALSE(is_sound(missing));
    CHECK_FALSE(is_sound(turned));
    CHECK_FALSE(is_sound(moved));
  }
}

TEST_CASE("Zero and minus zero are the same place, and a facet without area is no fault") {
  models::Facets box = models::box({0, 0, 0}, {1, 1, 1});
  for (Vertex& v : box[3].vertices)
    v = {v.x == 0 ? -0.0F : v.x, v.y == 0 ? -0.0F : v.y, v.z == 0 ? -0.0F : v.z};
  CHECK(is_sound(box));
  box.push_back({{Vertex{5, 5, 5}, Vertex{5, 5, 5}, Vertex{6, 5, 5}}});
  CHECK(is_sound(box));
}
