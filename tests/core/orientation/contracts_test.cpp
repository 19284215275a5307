// Checks that each header of core/orientation checks what it requires.
#include "core/orientation/nearly_level_base.hpp"
#include "core/orientation/orientation_choice.hpp"
#include "core/orientation/orientation_rating.hpp"
#include "core/orientation/rated_mesh.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

TEST_CASE("Choosing an orientation requires facets") {
  CHECK(contract_broken_by([] { (void)choose_orientation({}, {}); }) ==
        "there are facets, and fewer than 2^30");
}

TEST_CASE("The search for a nearly level base requires layers with a thickness") {
  CHECK(contract_broken_by([] { (void)nearly_level_base({}, {}, Nanometers{}); }) ==
        "a layer has a thickness");
  CHECK(contract_broken_by([] { (void)nearly_level_base({}, {}, Nanometers{1}); }).empty());
}

TEST_CASE("Rating requires a direction that is finite and not zero") {
  const models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  const RatedMesh mesh({.facets = facets});
  const OrientationRequest request;
  OrientationRating rating(mesh, request, OrientationRating::Mesh::Whole);
  CHECK(contract_broken_by([&] {
          (void)rating.rate({0, 0, 0});
        }) == "the upward direction is finite and not zero");
}

TEST_CASE("A sample requires room for a facet, and a rated mesh a weight for each facet and a cell size") {
  const models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  CHECK(contract_broken_by([&] { (void)sample_of(facets, {}, 0); }) ==
        "the sample may hold at least one facet");
  const std::vector<double> weights(facets.size() - 1, 1.0);
  CHECK(contract_broken_by([&] { RatedMesh({.facets = facets, .weights = weights}); }) ==
        "there is a weight for each facet, or for none");
  CHECK(contract_broken_by([&] { RatedMesh({.facets = facets, .cell_mm = 0}); }) == "cells have a size");
}
