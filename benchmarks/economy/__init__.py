"""Plans beside the best choice by hand: errors that were asked for and reached, and their cost."""
