// One painter for each kind of surface; all draw from the random stream they are given.
#pragma once

#include "sim/room/canvas.h"

namespace sim::room {

/// The random numbers a painter draws from and the number of the texture ("books_3": 3).
struct PaintRequest {
  cv::RNG random;
  int number;
};

// The room: paint_room.cc
Canvas paint_carpet(PaintRequest& request);      ///< 11 x 7 m; number 2: 25 x 7 m, not as sharp
Canvas paint_ceiling(PaintRequest& request);     ///< 11 x 7 m, with the regular grid of identical lights
Canvas paint_long_wall(PaintRequest& request);   ///< 11 x 3 m
Canvas paint_short_wall(PaintRequest& request);  ///< 7 x 3 m
Canvas paint_hall_wall(PaintRequest& request);   ///< 25 x 3 m (numbers 1, 2) or 18 x 3 m
Canvas paint_window(PaintRequest& request);      ///< 2.2 x 1.6 m, a view of the town
Canvas paint_door(PaintRequest& request);        ///< 0.95 x 2.1 m
Canvas paint_rug(PaintRequest& request);         ///< 2.4 x 1.7 m
Canvas paint_radiator(PaintRequest& request);    ///< 1.8 x 0.6 m

// The hall: paint_hall.cc
Canvas paint_vinyl(PaintRequest& request);         ///< 25 x 11 m; number 2: 6 x 4.8 m of it, sharper
Canvas paint_hall_ceiling(PaintRequest& request);  ///< a module of 2.4 x 3.6 m with one light, to be repeated
Canvas paint_lockers(PaintRequest& request);       ///< 1.2 x 1.8 m
Canvas paint_shutter(PaintRequest& request);       ///< 3.0 x 2.6 m

// Furnishing: paint_furnishing.cc, paint_paper.cc
Canvas paint_books(PaintRequest& request);    ///< 1.0 x 2.0 m, five shelves
Canvas paint_desk(PaintRequest& request);     ///< 1.6 x 0.8 m, seen from above, the side of the chair below
Canvas paint_screen(PaintRequest& request);   ///< 0.54 x 0.32 m
Canvas paint_drawers(PaintRequest& request);  ///< 0.42 x 0.58 m
Canvas paint_cabinet(PaintRequest& request);  ///< 1.2 x 0.8 m
Canvas paint_fabric(PaintRequest& request);   ///< 1.6 x 1.4 m
Canvas paint_carton(PaintRequest& request);   ///< 0.5 x 0.4 m
Canvas paint_poster(PaintRequest& request);   ///< 0.7 x 1.0 m
Canvas paint_whiteboard(PaintRequest& request);  ///< 2.4 x 1.2 m
Canvas paint_notices(PaintRequest& request);     ///< 1.5 x 1.0 m

}  // namespace sim::room
