"""From pixels to points: the target's dots or corners, the stripe, and how sure each place is."""
