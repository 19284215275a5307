#include "hw/gpio/encoder_edges.hpp"

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"

TEST_CASE("An encoder's period gives four counts, up while A leads and down while B leads") {
  Quadrature q(false, false);
  q.edge_a(true), q.edge_b(true), q.edge_a(false), q.edge_b(false);
  CHECK(q.count() == 4);
  q.edge_b(true), q.edge_a(true), q.edge_b(false), q.edge_a(false);
  CHECK(q.count() == 0);
  CHECK(q.illegal() == 0);
}

TEST_CASE("An edge to the level that a channel already has is illegal and does not count") {
  Quadrature q(false, false);
  q.edge_a(false);
  CHECK(q.count() == 0);
  CHECK(q.illegal() == 1);
}

TEST_CASE("An index mark is passed at the same count upwards and downwards") {
  testing::PlantInput a, b, index;
  EncoderEdges edges(&a, &b, &index);
  TimePoint now{1ms};
  const auto go = [&](std::initializer_list<std::pair<testing::PlantInput*, bool>> changes) {
    for (const auto& [line, level] : changes)
      line->set(level, now += 1ms);
    edges.serve(now + 1ms);
  };
  go({{&a, true}, {&b, true}, {&index, true}, {&a, false}, {&b, false}, {&index, false}, {&a, true}});
  CHECK(edges.index_pulses() == 1);
  CHECK(edges.index_count() == 2);
  CHECK(edges.counted().count() == 5);
  go({{&a, false}, {&index, true}, {&b, true}, {&a, true}, {&index, false}, {&b, false}});
  CHECK(edges.counted().count() == 1);
  CHECK(edges.index_pulses() == 2);
  CHECK(edges.index_count() == 2);
}

TEST_CASE("Edges of both lines are counted in the order of their times, whichever line is read first") {
  testing::PlantInput a, b;
  EncoderEdges edges(&a, &b);
  a.set(true, TimePoint{1ms});
  b.set(true, TimePoint{1100us});
  edges.serve(TimePoint{1200us});
  CHECK(edges.counted().count() == 0);  // line A may still deliver an earlier edge
  CHECK(edges.due() == TimePoint{1500us});
  a.set(false, TimePoint{1300us});
  edges.serve(TimePoint{2ms});
  CHECK(edges.counted().count() == 3);
  CHECK_FALSE(edges.due());
}

TEST_CASE("Edges are counted per line, including pending ones") {
  testing::PlantInput a, b, index;
  EncoderEdges edges(&a, &b, &index);
  a.set(true, TimePoint{1ms});
  a.set(false, TimePoint{2ms});
  index.set(true, TimePoint{2ms});
  edges.serve(TimePoint{2ms});
  CHECK(edges.edges(EncoderLine::A) == 2);
  CHECK(edges.edges(EncoderLine::B) == 0);
  CHECK(edges.edges(EncoderLine::Index) == 1);
}
