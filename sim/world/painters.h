// One painter for each kind of surface; all draw from the random stream they are given.
#pragma once

#include "sim/world/canvas.h"

namespace sim::world {

/// What a painter is given: its random numbers and the texture's number ("books_3": 3).
struct Commission {
  cv::RNG random;
  int number;
};

// The room: paint_room.cc
Canvas paint_carpet(Commission& c);      ///< 11 x 7 m; number 2: 25 x 7 m, not as sharp
Canvas paint_ceiling(Commission& c);     ///< 11 x 7 m, with the regular grid of identical lights
Canvas paint_long_wall(Commission& c);   ///< 11 x 3 m
Canvas paint_short_wall(Commission& c);  ///< 7 x 3 m
Canvas paint_hall_wall(Commission& c);   ///< 25 x 3 m (numbers 1, 2) or 18 x 3 m
Canvas paint_window(Commission& c);      ///< 2.2 x 1.6 m, a view of the town
Canvas paint_door(Commission& c);        ///< 0.95 x 2.1 m
Canvas paint_rug(Commission& c);         ///< 2.4 x 1.7 m
Canvas paint_radiator(Commission& c);    ///< 1.8 x 0.6 m

// The hall: paint_hall.cc
Canvas paint_vinyl(Commission& c);         ///< 25 x 11 m; number 2: 6 x 4.8 m of it, sharper
Canvas paint_hall_ceiling(Commission& c);  ///< a module of 2.4 x 3.6 m with one light, to be repeated
Canvas paint_lockers(Commission& c);       ///< 1.2 x 1.8 m
Canvas paint_shutter(Commission& c);       ///< 3.0 x 2.6 m

// What stands and hangs in it: paint_furnishing.cc, paint_paper.cc
Canvas paint_books(Commission& c);       ///< 1.0 x 2.0 m, five shelves
Canvas paint_desk(Commission& c);        ///< 1.6 x 0.8 m, seen from above, the user's side below
Canvas paint_screen(Commission& c);      ///< 0.54 x 0.32 m
Canvas paint_drawers(Commission& c);     ///< 0.42 x 0.58 m
Canvas paint_cabinet(Commission& c);     ///< 1.2 x 0.8 m
Canvas paint_fabric(Commission& c);      ///< 1.6 x 1.4 m
Canvas paint_carton(Commission& c);      ///< 0.5 x 0.4 m
Canvas paint_poster(Commission& c);      ///< 0.7 x 1.0 m
Canvas paint_whiteboard(Commission& c);  ///< 2.4 x 1.2 m
Canvas paint_notices(Commission& c);     ///< 1.5 x 1.0 m

}  // namespace sim::world
