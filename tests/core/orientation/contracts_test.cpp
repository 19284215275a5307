// That each header of core/orientation checks what it requires.
#include "core/orientation/orientation_choice.hpp"
#include "core/orientation/orientation_rating.hpp"
#include "core/orientation/rated_mesh.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using testing::contract_broken_by;

TEST_CASE("A way up is chosen for a model that has facets") {
  CHECK(contract_broken_by([] { (void)choose_orientation({}, {}); }) ==
        "there are facets, and fewer than 2^30");
}

TEST_CASE("Directions that are rated are directions") {
  const models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  const RatedMesh mesh({.facets = facets});
  const OrientationRequest request;
  OrientationRating rating(mesh, request, OrientationRating::Mesh::Whole);
  CHECK(contract_broken_by([&] {
          (void)rating.rate({0, 0, 0});
        }) == "the upward direction is finite and not zero");
}

TEST_CASE("A sample may hold facets, each with its weight, in cells of some size") {
  const models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  CHECK(contract_broken_by([&] { (void)sample_of(facets, 0); }) == "the sample may hold a facet");
  const std::vector<double> weights(facets.size() - 1, 1.0);
  CHECK(contract_broken_by([&] { RatedMesh({.facets = facets, .weights = weights}); }) ==
        "each facet has its weight");
  CHECK(contract_broken_by([&] { RatedMesh({.facets = facets, .cell_mm = 0}); }) == "cells have a size");
}
