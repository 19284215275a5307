#include "daemon/prepare/mesh_repair_text.hpp"

#include "tests/catch.hpp"

using namespace contourd;

TEST_CASE("Repairs are told with their numbers, and nothing is told of none") {
  CHECK(describe({}).empty());
  CHECK(describe({17, 0, 0, 0}) == "17 facets turned round");
  CHECK(describe({1, 1, 0, 0}) == "1 facet turned round, 1 facet left out for being there once more");
  CHECK(describe({0, 0, 3, 4}) ==
        "3 facets left out for being there once more, reversed, 4 facets of walls inside left out");
  CHECK(repair_warning({2, 0, 0, 0}) == "the model's facets disagree with each other: 2 facets turned round");
}

TEST_CASE("Repairs as JSON have every figure") {
  CHECK(repairs_json({1, 2, 3, 4}).dump() ==
        R"({"turned_facets":1,"doubled_facets":2,"reversed_facets":3,"inner_wall_facets":4})");
}
