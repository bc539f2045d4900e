#include "walking/cart_table.h"

namespace walking {

CartTable::CartTable(double com_height, double period, double gravity) {
  const double T = period;
  A << 1, T, T * T / 2, 0, 1, T, 0, 0, 1;
  B << T * T * T / 6, T * T / 2, T;
  C << 1, 0, -com_height / gravity;
}

}  // namespace walking
