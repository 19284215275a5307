#include "core/model/height_index.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

namespace {

using Key = std::array<float, 9>;

Key key_of(const Facet& f) {
  const auto& [a, b, c] = f.vertices;
  return {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
}

// The slicer's rule: a vertex at exactly z is below.
bool crosses(const Facet& facet, double z) {
  const auto above = std::ranges::count_if(facet.vertices, [z](const Vertex& v) { return v.z > z; });
  return above == 1 || above == 2;
}

std::vector<Key> crossing(std::span<const Facet> facets, double z) {
  std::vector<Key> keys;
  for (const Facet& facet : facets) {
    if (crosses(facet, z)) keys.push_back(key_of(facet));
  }
  return keys;
}

std::vector<Key> crossing_candidates(const HeightIndex& index, double z) {
  std::vector<Key> keys;
  index.for_each_candidate_run(z, [&](std::span<const HeightIndex::Candidate> run) {
    for (const HeightIndex::Candidate& candidate : run) {
      const Facet& facet = index.facets()[candidate.facet];
      if (crosses(facet, z)) keys.push_back(key_of(facet));
    }
  });
  return keys;
}

std::vector<Key> sorted(std::vector<Key> keys) {
  std::ranges::sort(keys);
  return keys;
}

std::vector<Key> keys_of(std::span<const Facet> facets) {
  std::vector<Key> keys;
  for (const Facet& facet : facets)
    keys.push_back(key_of(facet));
  return keys;
}

std::size_t candidates(const HeightIndex& index, double z) {
  std::size_t count = 0;
  index.for_each_candidate_run(z, [&](std::span<const HeightIndex::Candidate> run) { count += run.size(); });
  return count;
}

// Facets of all kinds: as high as the model, tiny, flat; at heights that meet the cells' borders as well.
models::Facets draw_facets() {
  models::Facets facets(static_cast<std::size_t>(testing::draw(1, 60)));
  const float shift = testing::draw_float(-1000, 1000);
  for (Facet& facet : facets) {
    facet = testing::draw_facet(50);
    const auto kind = testing::draw(0, 4);
    float low = testing::draw_float(-50, 50);
    if (kind == 4) low = static_cast<float>(testing::draw(-50, 50));
    const float heights[] = {100.0F, 1e-6F, 0.0F, 1.0F, 12.5F};
    for (Vertex& v : facet.vertices) {
      if (kind > 0) v.z = low + heights[kind] * testing::draw_float(0, 1);
      v.z += shift;
    }
  }
  return facets;
}

}  // namespace

TEST_CASE("The candidates contain every facet that a full scan finds, exactly once") {
  CHECK(rc::check([] {
    const models::Facets facets = draw_facets();
    const HeightIndex index(facets);
    std::vector<double> heights;
    for (const Facet& facet : facets) {
      for (const Vertex& v : facet.vertices) {
        const double z = v.z;
        heights.insert(heights.end(), {z, std::nextafter(z, -1e9), std::nextafter(z, 1e9)});
      }
    }
    for (int i = 0; i < 20; ++i)
      heights.push_back(testing::draw_real(-1100, 1100));
    // The borders between the index's own cells.
    for (int i = 0; i <= 64; ++i) {
      heights.push_back(index.bounds().min_z + index.bounds().size_z() * i / 64);
    }
    for (const double z : heights) {
      RC_ASSERT(sorted(crossing_candidates(index, z)) == sorted(crossing(index.facets(), z)));
    }
  }));
}

TEST_CASE("The index keeps the facets' order and turns an inside-out model") {
  const models::Facets box = models::box({-1, -2, -3}, {4, 5, 6});
  models::Facets turned = box;
  for (Facet& facet : turned)
    std::swap(facet.vertices[1], facet.vertices[2]);
  const HeightIndex index(box);
  CHECK_FALSE(index.turned_outwards());
  CHECK(keys_of(index.facets()) == keys_of(box));
  const HeightIndex from_turned(turned);
  CHECK(from_turned.turned_outwards());
  CHECK(keys_of(from_turned.facets()) == keys_of(box));
}

TEST_CASE("An open model is turned only if its gaps leave no doubt") {
  models::Facets sheet = models::box({0, 0, 0}, {20, 20, 20});
  sheet.resize(2);
  CHECK_FALSE(HeightIndex(sheet).turned_outwards());
  models::invert(sheet);
  CHECK_FALSE(HeightIndex(sheet).turned_outwards());
  models::Facets ball = models::globe(10, 16, 32);
  models::invert(ball);
  ball.pop_back();
  CHECK(HeightIndex(ball).turned_outwards());
}

TEST_CASE("Candidates hold their facets' heights") {
  CHECK(rc::check([] {
    const HeightIndex index(draw_facets());
    index.for_each_candidate_run(testing::draw_real(-1100, 1100),
                                 [&](std::span<const HeightIndex::Candidate> run) {
                                   for (const HeightIndex::Candidate& candidate : run) {
                                     const auto& v = index.facets()[candidate.facet].vertices;
                                     RC_ASSERT(candidate.low == std::min({v[0].z, v[1].z, v[2].z}));
                                     RC_ASSERT(candidate.high == std::max({v[0].z, v[1].z, v[2].z}));
                                   }
                                 });
  }));
}

TEST_CASE("The index returns the model's bounds") {
  const HeightIndex index(models::box({-1, -2, -3}, {4, 5, 6}));
  CHECK(index.bounds().min_x == -1.0);
  CHECK(index.bounds().max_y == 5.0);
  CHECK(index.bounds().min_z == -3.0);
  CHECK(index.bounds().size_z() == 9.0);
}

TEST_CASE("A model without height and no model at all have no candidates") {
  const HeightIndex flat(models::Facets{{{Vertex{0, 0, 5}, Vertex{1, 0, 5}, Vertex{0, 1, 5}}}});
  CHECK(flat.facets().size() == 1);
  CHECK(candidates(flat, 5.0) == 0);
  const HeightIndex none;
  CHECK(none.bounds().empty());
  CHECK(candidates(none, 0.0) == 0);
  CHECK(candidates(HeightIndex(models::Facets{}), 0.0) == 0);
}

TEST_CASE("Outside the model's height there are no candidates") {
  const HeightIndex index(models::box({0, 0, 0}, {1, 1, 10}));
  CHECK(candidates(index, -1e-9) == 0);
  CHECK(candidates(index, 0.0) > 0);
  CHECK(candidates(index, 10.0) == 0);
  CHECK(candidates(index, std::numeric_limits<double>::quiet_NaN()) == 0);
  CHECK(candidates(index, std::numeric_limits<double>::infinity()) == 0);
  CHECK(candidates(index, -std::numeric_limits<double>::infinity()) == 0);
}

TEST_CASE("Models of the largest and the smallest floats are indexed") {
  for (const float size : {std::numeric_limits<float>::max(), std::numeric_limits<float>::denorm_min()}) {
    const models::Facets facets = models::box({0, 0, -size}, {1, 1, size});
    const HeightIndex index(facets);
    CHECK(sorted(crossing_candidates(index, 0.0)) == sorted(crossing(facets, 0.0)));
    CHECK_FALSE(crossing(facets, 0.0).empty());
  }
}

TEST_CASE("A query touches few facets that it does not cross") {
  const HeightIndex index(models::sphere(20, 48));
  std::size_t touched = 0, crossed = 0;
  for (double z = -19.5; z < 19.5; z += 0.37) {
    touched += candidates(index, z);
    crossed += crossing_candidates(index, z).size();
  }
  // The header states 2.7 candidates for each crossing, on average over all shapes of facets; half as many
  // again for a sphere's own mix of facets.
  CHECK(static_cast<double>(touched) < 4.0 * static_cast<double>(crossed));
  CHECK(crossed > 1000);
}

TEST_CASE("A range of heights finds every facet with a point in it, flat ones included") {
  CHECK(rc::check([] {
    models::Facets facets = testing::draw_blobs(6);
    const auto box = models::box({0, 0, 0}, {3, 3, static_cast<float>(testing::draw_real(0.1, 9))});
    facets.insert(facets.end(), box.begin(), box.end());
    const HeightIndex index(facets);
    const double height = index.bounds().size_z();
    for (int i = 0; i < 20; ++i) {
      // Sometimes at a vertex's own height, and beyond the model's ends.
      const auto chosen =
          static_cast<std::size_t>(testing::draw(0, static_cast<std::int64_t>(facets.size()) - 1));
      const double low = testing::draw(0, 1) == 1
                             ? double{facets[chosen].vertices[0].z}
                             : index.bounds().min_z + testing::draw_real(-0.2, 1.2) * height;
      const double high = low + (testing::draw(0, 3) == 0 ? 0.0 : testing::draw_real(0, 0.3) * height);
      std::size_t expected = 0, found = 0;
      const auto in_range = [&](const Facet& f) {
        const auto [a, b, c] = f.vertices;
        return std::max({a.z, b.z, c.z}) >= low && std::min({a.z, b.z, c.z}) <= high;
      };
      for (const Facet& facet : facets)
        expected += in_range(facet) ? 1U : 0U;
      index.for_each_candidate_run(low, high, [&](std::span<const HeightIndex::Candidate> run) {
        for (const HeightIndex::Candidate& candidate : run)
          found += in_range(index.facets()[candidate.facet]) ? 1U : 0U;
      });
      RC_ASSERT(found == expected);
    }
  }));
}

TEST_CASE("A range of heights finds a model without height, and nothing in a model without facets") {
  const HeightIndex flat(models::box({0, 0, 2}, {1, 1, 2}));
  const auto found = [](const HeightIndex& index, double low, double high) {
    std::size_t facets = 0;
    index.for_each_candidate_run(low, high,
                                 [&](std::span<const HeightIndex::Candidate> run) { facets += run.size(); });
    return facets;
  };
  CHECK(found(flat, 1, 3) == 12);
  CHECK(found(flat, 2, 2) == 12);
  CHECK(found(flat, 2.1, 3) == 0);
  CHECK(found(HeightIndex(), -1, 1) == 0);
}
