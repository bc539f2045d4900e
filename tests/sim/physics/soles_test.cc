#include <gtest/gtest.h>

#include "tests/sim/physics/test_worlds.h"

namespace sim::physics {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

Vector2d horizontal(const Eigen::Isometry3d& X) { return X.translation().head<2>(); }

TEST(Soles, PressEvenlyEnoughToResistYawAsAFlatSoleDoes) {
  World world = standing();
  run(world, 2000);
  const mjData* d = world.data();
  double load = 0, moment = 0;
  const Vector2d middle = (world.X_WL() * Vector3d(0.015, 0, 0)).head<2>();
  for (const mjContact* c = d->contact; c < d->contact + d->ncon; ++c) {
    const Vector2d place(c->pos[0], c->pos[1]);
    if (place.y() < 0) continue;  // of the right foot
    load += d->efc_force[c->efc_address];
    moment += d->efc_force[c->efc_address] * (place - middle).norm();
  }
  EXPECT_GT(load, 200);
  // Mean distance of the points of 0.230 x 0.138 m from their middle; only four corners: 0.134.
  EXPECT_NEAR(moment / load, 0.0717, 0.002);
}

TEST(Soles, CreepIsTheMotionOfAStandingFootBelowTheFrictionCone) {
  WorldOptions options;
  options.pushes = {{.time_s = 1, .impulse_ns = 60, .direction_rad = 0, .duration_s = 3}};  // 20 of 84 N
  World world = standing({}, Eigen::Isometry3d::Identity(), options);
  run(world, 1500);
  world.sole_contacts_since_last();
  const Vector2d before = horizontal(world.X_WL());
  run(world, 2000);
  const Vector2d moved = horizontal(world.X_WL()) - before;
  const SoleContact contact = world.sole_contacts_since_last()[0];
  EXPECT_GT(moved.x(), 1e-6);
  EXPECT_LT(moved.x(), 3e-4);  // a tenth of a millimetre a second
  // The push tilts the sole a little on its pads, which moves the point below the ankle too.
  EXPECT_NEAR(contact.creep.x(), moved.x(), 0.2 * moved.x());
  EXPECT_NEAR(contact.load, walking::hrp2::kMass * walking::kGravity / 2, 15);  // both feet alike
}

TEST(Soles, SlideWhereTheFloorIsSlippery) {
  WorldOptions options;
  options.pushes = {{.time_s = 0.5, .impulse_ns = 20, .direction_rad = 0, .duration_s = 1}};
  World dry = standing({}, Eigen::Isometry3d::Identity(), options);
  options.floor_patches = {{-1, 1, -1, 1, 0.02}};
  World wet = standing({}, Eigen::Isometry3d::Identity(), options);
  run(dry, 1500);
  run(wet, 1500);
  EXPECT_LT(dry.X_WL().translation().x() - 0.0095, 0.001);
  EXPECT_GT(wet.X_WL().translation().x() - 0.0095, 0.02);
}

TEST(Soles, StandOnTheFloorsHeight) {
  PlantVariation draw;
  draw.floor = {{0.004, Vector2d(0, 2), 0}};  // 4 mm cos(2 y): even in x
  World world = standing(draw);
  run(world, 1000);
  const double height = height_at(horizontal(world.X_WL()), draw.floor);
  EXPECT_GT(height, 0.0035);
  EXPECT_NEAR(world.X_WL().translation().z(), height, 0.001);  // the pads yield
}

TEST(Ground, OfSeveralPatchesTheLastOneCounts) {
  const std::vector<FloorPatch> patches{{0, 2, 0, 2, 0.3}, {1, 2, 0, 2, 0.4}};
  EXPECT_EQ(friction_at({-0.1, 1}, 0.7, patches), 0.7);
  EXPECT_EQ(friction_at({0.5, 1}, 0.7, patches), 0.3);
  EXPECT_EQ(friction_at({1.5, 1}, 0.7, patches), 0.4);
}

TEST(Push, GoesByTheHeadingOfTheWaist) {
  WorldOptions options;
  options.pushes = {{.time_s = 0.2, .impulse_ns = 10, .direction_rad = std::numbers::pi / 2}};
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()));
  World world = standing({}, X_WB, options);
  run(world, 200);
  const Vector3d before = world.com();
  run(world, 100);
  const Vector3d moved = world.com() - before;
  // Heading 90 deg, push to the left of it: towards -x. Free, 10 Ns on 57 kg would be 9 mm in 0.1 s.
  EXPECT_LT(moved.x(), -0.003);
  EXPECT_GT(moved.x(), -0.009);
  EXPECT_LT(std::abs(moved.y()), 0.001);
}

}  // namespace
}  // namespace sim::physics
