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

// Returns the facets' vertices, which can be compared.
std::vector<std::array<Vertex, 3>> vertices_of(const std::vector<Facet>& facets) {
  std::vector<std::array<Vertex, 3>> vertices;
  for (const Facet& facet : facets)
    vertices.push_back(facet.vertices);
  return vertices;
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

TEST_CASE("Slivers and folded facets beside a model are left out with a warning, wherever they are") {
  struct Case {
    const char* name;
    models::Facets strays;
  };
  const Facet folded{{Vertex{5, 4, -3}, Vertex{8, 4, -3}, Vertex{5, 7, -2}}};
  models::Facets fan;
  for (int i = 0; i < 5; ++i) {
    const float x = static_cast<float>(i);
    fan.push_back({{Vertex{40, 4, -3}, Vertex{41 + x, 4, x}, Vertex{42 + x, 4, x + 1}}});
    fan.push_back({{Vertex{40, 4, -3}, Vertex{42 + x, 4, x + 1}, Vertex{41 + x, 4, x}}});
  }
  const auto sliver = [](const Vertex& at, float size) {
    return Facet{{at, Vertex{at.x + size, at.y, at.z}, Vertex{at.x, at.y + size, at.z}}};
  };
  for (const Case& each : std::vector<Case>{
           {"1 nm", {sliver({5, 4, -3}, 1e-6F)}},
           {"1 um", {sliver({5, 4, -3}, 1e-3F)}},
           {"10 um", {sliver({5, 4, -3}, 1e-2F)}},
           {"far away", {sliver({500, 4, 1}, 1e-3F)}},
           {"a needle", {{{Vertex{5, 4, -3}, Vertex{5, 4, -9}, Vertex{5.001F, 4, -9}}}}},
           {"a needle through the box", {{{Vertex{5, 4, 2}, Vertex{5, 4, -9}, Vertex{5.001F, 4, -9}}}}},
           {"several", {sliver({5, 4, -3}, 1e-3F), sliver({7, 4, -3}, 1e-3F), sliver({5, 4, 30}, 1e-3F)}},
           {"a folded pair", {folded, models::inverted({folded})[0]}},
           {"a folded fan", fan},
           {"a sliver beyond a folded pair",
            {folded, models::inverted({folded})[0], sliver({5, 4, -9}, 1e-3F)}},
       }) {
    for (const std::size_t position : {std::size_t{0}, std::size_t{5}, std::size_t{12}}) {
      CAPTURE(each.name, position);
      Model model{models::box({0, 0, 0}, {10, 8, 4}), {}};
      model.facets.insert(model.facets.begin() + static_cast<std::ptrdiff_t>(position), each.strays.begin(),
                          each.strays.end());
      drop_stray_facets(model);
      CHECK(vertices_of(model.facets) == vertices_of(models::box({0, 0, 0}, {10, 8, 4})));
      REQUIRE(model.warnings.size() == 1);
      CHECK(lacking(model.warnings[0], {each.strays.size() == 1 ? "one facet" : " facets",
                                        "enclosing nothing", "left out", " mm"}) == "");
    }
  }
}

TEST_CASE("Parts that are thin, small or open are kept") {
  const models::Facets box = models::box({0, 0, 0}, {10, 8, 4});
  const auto scaled = [](models::Facets facets, float factor) {
    for (Facet& facet : facets)
      for (Vertex& v : facet.vertices)
        v = {v.x * factor, v.y * factor, v.z * factor};
    return facets;
  };
  models::Facets sheet{{{Vertex{5, 4, -3}, Vertex{8, 4, -3}, Vertex{5, 7, -2}}}};
  models::Facets spike{{{Vertex{10, 8, 4}, Vertex{10, 8, 6}, Vertex{10, 8.001F, 6}}}};
  models::Facets ball = scaled(models::globe(5, 100, 200), 0.05F);
  models::translate(ball, 5, 4, -3);
  models::Facets wire = models::box({5, 4, -9}, {5.01F, 4.01F, -3});
  models::Facets pin = models::cone(0.3, 5, 300);
  models::translate(pin, 5, 4, 4);
  const models::Facets plates = models::together(box, models::box({3, 3, 6}, {4, 4, 7}));
  for (const models::Facets& facets :
       {models::together(box, sheet), models::together(box, spike), models::together(box, ball),
        models::together(box, wire), models::together(box, pin), scaled(plates, 1e-3F),
        scaled(models::together(box, ball), 1e-3F), models::together(models::together(sheet, sheet), box),
        models::globe(30, 90, 700), models::globe(0.01, 20, 40),
        models::together(sheet, models::inverted(sheet))}) {
    Model model{facets, {}};
    drop_stray_facets(model);
    CHECK(vertices_of(model.facets) == vertices_of(facets));
    CHECK(model.warnings.empty());
  }
}

TEST_CASE("The walls that two boxes share are kept") {
  const models::Facets facets =
      models::together(models::box({0, 0, 0}, {10, 8, 4}), models::box({10, 0, 0}, {12, 8, 4}));
  Model model{facets, {}};
  drop_stray_facets(model);
  CHECK(vertices_of(model.facets) == vertices_of(facets));
}
