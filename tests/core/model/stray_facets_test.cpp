#include "core/model/stray_facets.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

namespace {

Facet point_at(const Vertex& place) {
  return {{place, place, place}};
}

Model box_with(std::initializer_list<Facet> strays, std::size_t position) {
  Model model{models::box({0, 0, 0}, {10, 8, 4}), {}};
  model.facets.insert(model.facets.begin() + static_cast<std::ptrdiff_t>(position), strays);
  return model;
}

}  // namespace

TEST_CASE("Points and lines outside a model are left out with a warning, wherever they are in the file") {
  const std::initializer_list<Facet> strays{
      point_at({5, 5, -25}),
      point_at({1e30F, 0, 0}),
      {{Vertex{0, 0, 0}, Vertex{5, 0, 0}, Vertex{20, 0, 0}}},
      {{Vertex{1, 1, 1}, Vertex{2, 2, 4.125F}, Vertex{1, 1, 1}}},
  };
  for (const std::size_t position : {std::size_t{0}, std::size_t{5}, std::size_t{12}}) {
    CAPTURE(position);
    Model model = box_with(strays, position);
    drop_stray_facets(model);
    CHECK(model.facets.size() == 12);
    CHECK(bounds_of(model.facets).size_z() == 4);
    REQUIRE(model.warnings.size() == 1);
    CHECK(lacking(model.warnings[0], {"4 facets without area", "left out", "5, 5, -25 mm"}) == "");
  }
}

TEST_CASE("A single point beside a model is reported with its place") {
  Model model = box_with({point_at({0.1F, 9, 0})}, 3);
  drop_stray_facets(model);
  REQUIRE(model.warnings.size() == 1);
  CHECK(lacking(model.warnings[0], {"one facet without area", "0.1, 9, 0 mm"}) == "");
}

TEST_CASE("Facets without area within a model are kept") {
  Model model = box_with({point_at({5, 5, 2}), {{Vertex{0, 0, 0}, Vertex{10, 0, 0}, Vertex{5, 0, 0}}}}, 0);
  drop_stray_facets(model);
  CHECK(model.facets.size() == 14);
  CHECK(model.warnings.empty());
}

TEST_CASE("A model in which no facet has an area is kept as it is") {
  Model model{{point_at({1, 2, 3}), point_at({4, 5, 6})}, {}};
  drop_stray_facets(model);
  CHECK(model.facets.size() == 2);
  CHECK(model.warnings.empty());
}

TEST_CASE("Facets that have an area are never left out, however they follow each other") {
  CHECK(rc::check([] {
    Model model;
    for (std::int64_t i = testing::draw(1, 300); i > 0; --i)
      model.facets.push_back(testing::draw_facet(500));
    const auto has_area = [](const Facet& facet) { return twice_area(facet) > 0; };
    const auto before = std::ranges::count_if(model.facets, has_area);
    drop_stray_facets(model);
    RC_ASSERT(std::ranges::count_if(model.facets, has_area) == before);
  }));
}
