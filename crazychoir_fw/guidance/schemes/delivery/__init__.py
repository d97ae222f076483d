"""Pickup and delivery: drones share out requests and plan their routes, by distributed simplex over routes.

The long version of the paper shows such an experiment and releases no code, so the scheme here is chosen: requests are
partitioned among drones as in column generation for vehicle routing (Dumas, Desrosiers and Soumis 1991), each drone
makes the columns of its own routes, and the linear program over all of them is solved by distributed simplex (Buerger,
Notarstefano, Bullo and Allgoewer 2012). Where its solution is fractional, columns are fixed one after the other.
"""

from crazychoir_fw.guidance.schemes.delivery.delivery_guidance import DeliveryGuidance
from crazychoir_fw.guidance.schemes.delivery.delivery_request import DeliveryRequest
from crazychoir_fw.guidance.schemes.delivery.delivery_table import DeliveryTable
from crazychoir_fw.guidance.schemes.delivery.routes import Route, Stop, best_routes

__all__ = ["DeliveryGuidance", "DeliveryRequest", "DeliveryTable", "Route", "Stop", "best_routes"]
